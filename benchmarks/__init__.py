"""Benchmarks: each asserts its answers, and prints what they took, peers side by side."""
