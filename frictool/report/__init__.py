"""Metrics against the specification: the verdict, as a page and for machines."""
