"""Parameter sweeps: one case solved for many values of some of its keys.

`points` has the swept axes and makes checked points; `sweep` solves them in batches of neighbours and reads rows back;
`table` writes the rows as CSV, HDF5 and data frame; `table_picture` draws them.
"""
