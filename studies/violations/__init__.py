"""Machines that violate the model of `identify`, and the coverage of its intervals on them."""
