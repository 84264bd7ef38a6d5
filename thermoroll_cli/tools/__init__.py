"""Many pieces of work: `runner` works them off here, in processes of this machine or on a Dask cluster, and `journal` keeps
each finished one on the disk. Neither knows the content of the work."""
