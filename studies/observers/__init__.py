"""Experiments on estimators of velocity, friction and wear."""
