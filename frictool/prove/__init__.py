"""Proofs of a controller's step test, and the check of a stored proof."""
