"""Compilation of kernels, and the cache that keeps them on disk between runs."""
