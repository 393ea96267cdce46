"""Subjects: designs, assemblies and scenes, by the names and files that people give."""
