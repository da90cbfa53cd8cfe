"""Functions for programs: the stages over logs and documents in memory, and their linear
systems."""
