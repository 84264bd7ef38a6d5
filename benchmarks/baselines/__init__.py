"""What thermoroll is measured against: other discretisations and solvers, only for the benchmark."""
