"""A log in memory, its formats (one file each), and the mapping of raw columns to channels."""
