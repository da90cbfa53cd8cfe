"""Linear least squares on rows of regressors, with intervals that hold under correlated residuals;
what is known of what it leaves out."""
