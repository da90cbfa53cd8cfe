"""The command line: one thin file per command that parses, loads, calls one stage and saves."""
