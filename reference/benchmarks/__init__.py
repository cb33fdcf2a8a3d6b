"""Benchmarks: run time against error, measured one thing at a time."""
