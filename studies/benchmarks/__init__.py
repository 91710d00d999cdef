"""Benchmarks: time against error, and how far tolerances and digits can be trusted."""
