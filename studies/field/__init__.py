"""Benchmark on measured records of other people's machines."""
