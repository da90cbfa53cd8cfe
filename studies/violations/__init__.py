"""Coverage of the intervals of `identify` on machines that violate its model."""
