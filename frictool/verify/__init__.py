"""The closed loop rebuilt from coefficients: stability, norms, margins, sampled. Knows no solver."""
