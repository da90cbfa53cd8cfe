"""Identification methods, one module each; `methods.py` lists the methods."""
