"""The bench `scale`: the whole command on more processes, on a cluster, and into databases."""
