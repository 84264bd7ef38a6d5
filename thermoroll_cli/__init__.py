"""Three-dimensional thermo-elastic rolling contact in the steady state."""

__version__ = "0.1.0"
