"""Observers designed from a model and verified before they are written."""
