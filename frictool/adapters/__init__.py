"""Documents as records of `plant` and `control`, and back."""
