"""One friction law or hysteresis operator per file: kernels on SI floats and arrays; `table.LAWS`
lists the laws."""
