"""Page and figures of an identified model."""
