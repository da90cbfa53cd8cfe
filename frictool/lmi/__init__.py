"""Synthesis of controllers and observer gains by linear matrix inequalities."""
