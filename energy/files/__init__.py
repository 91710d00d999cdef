"""Readers of text files and of measured profiles."""
