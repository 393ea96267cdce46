"""Certificates of paths and of locks: plain data that a stranger can check, and the program that checks it."""
