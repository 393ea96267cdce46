"""The atlas: the results on all designs with up to n panels, as files to publish."""
