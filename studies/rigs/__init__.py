"""Simulated rigs: plants, documents and logs to try a stage on."""
