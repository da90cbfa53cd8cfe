"""One friction law per file: kernels on SI floats."""
