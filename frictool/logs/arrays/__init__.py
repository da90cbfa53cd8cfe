"""Readers and writers of array files: MATLAB, NumPy, MDF and Parquet."""
