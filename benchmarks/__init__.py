"""Timings against peers: `make bench`. Each bench_*.py here defines ROWS, functions that return one
row of the table each."""
