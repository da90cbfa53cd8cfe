"""Proofs of a controller's step test, and their independent check."""
