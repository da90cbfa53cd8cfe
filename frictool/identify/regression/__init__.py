"""Linear least squares; the intervals of the parameters allow for correlated residuals."""
