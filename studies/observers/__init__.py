"""Experiments with estimators of velocity, friction and wear."""
