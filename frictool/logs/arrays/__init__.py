"""Files of arrays: MATLAB, NumPy, MDF, Parquet."""
