"""One contact, solved on one grid (`steady_state`) and then on a sequence of grids with estimated errors (`refinement`)."""
