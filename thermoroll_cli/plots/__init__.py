"""Pictures of results and sweeps, drawn with matplotlib for print: plain functions from a result to a figure.

`pictures` has the table of all kinds of pictures of a run; a new kind is a function and a line there. `style` has the sizes
of columns and the file formats, `thermoroll.mplstyle` the look, `run_frame` what all pictures of one run share.
"""
