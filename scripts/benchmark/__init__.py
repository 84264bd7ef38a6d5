"""Run time against error: `make bench`."""
