"""Statistics of trials: pass rate, distributions, and sensitivities of failures and metrics."""
