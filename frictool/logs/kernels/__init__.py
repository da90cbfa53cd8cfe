"""Compiled loops that convert bytes and encoder signals to numbers."""
