"""Recipes of CONTRIBUTING.md, followed with the dummies that stand in them."""
