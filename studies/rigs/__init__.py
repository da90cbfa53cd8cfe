"""Simulated rigs for tests and experiments: plants, documents and logs."""
