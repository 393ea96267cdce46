"""The bench `experiment`: the thesis's deployment of the 4x4 array (4.5)."""
