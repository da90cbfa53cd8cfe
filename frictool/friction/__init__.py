"""Friction laws and hysteresis operators, one per file; `law_registry.LAWS` lists the laws.

A kernel is a compiled function. All kernels take and return floats and arrays in SI units. Units of
a linear and of a rotary axis are separated by |, as in "m | rad" and "N | N m".
"""
