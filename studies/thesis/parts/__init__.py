"""Parts of the reproduction. Each is a function without arguments that returns its tables and
figures."""
