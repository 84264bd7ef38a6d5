"""The steady state on one grid: press, roll, heat, expand (Fig. 2)."""
