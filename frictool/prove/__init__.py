"""Proofs that a controller meets the requirements of a step test for all starts and plants."""
