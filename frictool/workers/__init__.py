"""Sharing of jobs of any kind among processes or the workers of a Dask cluster."""
