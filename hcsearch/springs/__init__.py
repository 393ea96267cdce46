"""Whether springs or motors move a folding: bodies, deployments, tuning, drives, measured springs."""
