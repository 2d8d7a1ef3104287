"""Benchmarks, each with its baseline in the same run: ``python -m benchmarks`` or ``python -m benchmarks.NAME``."""
