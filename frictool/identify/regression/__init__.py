"""Linear least squares with intervals for correlated residuals."""
