"""Foldings moved by springs or motors: multibody dynamics, deployments, tuning, drives, measured springs."""
