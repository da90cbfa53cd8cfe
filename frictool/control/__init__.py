"""Blocks of controllers and observers: the operations of the target at every sample."""
