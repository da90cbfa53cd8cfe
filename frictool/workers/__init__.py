"""Sharing of jobs, of any content, among processes or the workers of a Dask cluster."""
