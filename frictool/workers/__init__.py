"""Distribution of jobs to processes or to the workers of a Dask cluster."""
