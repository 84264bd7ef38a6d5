"""Parameter sweeps: one case solved for many values of some of its keys.

`points` has the swept axes and makes checked points; `sweep` solves them in batches of neighbours and reads rows back;
`table` makes rows and columns of them, which `files/table_file.py` writes and reads, and `table_picture` draws them.
"""
