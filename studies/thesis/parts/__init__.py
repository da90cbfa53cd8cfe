"""Parts of the reproduction; each is a function that returns its tables and figures."""
