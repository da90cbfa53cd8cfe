"""The parts of the reproduction: each a function without arguments, with the tables and figures
that it makes."""
