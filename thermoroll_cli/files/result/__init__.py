"""Result files: HDF5, exports, comparison."""
