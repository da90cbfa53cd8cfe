"""A model against a measured log."""
