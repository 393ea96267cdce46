"""Stage `mobility`: degrees of freedom and locks of whole batches of foldings."""
