"""Comparison of identified half widths with the promises of optimal tests, on ten benches."""
