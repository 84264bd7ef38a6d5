"""Thousands of random cases: `make stress`."""
