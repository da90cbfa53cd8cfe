"""Linear least squares with intervals that hold for correlated residuals."""
