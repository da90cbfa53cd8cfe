"""Step tests of a model under its controller, as a log."""
