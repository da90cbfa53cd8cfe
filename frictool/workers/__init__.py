"""Work shared among processes of this machine, or the workers of a Dask cluster; knows no documents
and no logs."""
