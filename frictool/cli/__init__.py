"""Command line: one module per command; each loads inputs, calls one stage and saves the result."""
