"""Timings of frictool against peers: `make bench`.

Each file bench_*.py defines ROWS, a list of functions; each function returns one row of the table.
"""
