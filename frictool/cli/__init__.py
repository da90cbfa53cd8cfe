"""Command line: one module per command, which parses, loads, calls one stage and saves."""
