"""Parameter sweeps: one case solved for many values of some of its keys.

`points` says what is swept and makes checked points; `sweep` solves them in stretches of neighbours and reads rows back;
`table` writes the rows as CSV, HDF5, picture and data frame. Below stand two tools that tables of creep forces use as well:
`runner` has tasks worked off here, in processes or by a Dask cluster, and `journal` keeps each finished point on the disk.
"""
