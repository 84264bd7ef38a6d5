"""Fine reference values that tests and benchmarks compare with."""
