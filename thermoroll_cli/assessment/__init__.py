"""What is reported of a state: scalars, and the checks that each run makes of itself."""
