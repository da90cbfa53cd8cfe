"""Command line: one module per command; each loads inputs, calls a package and saves results."""
