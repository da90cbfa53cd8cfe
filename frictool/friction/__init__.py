"""Friction laws and hysteresis operators, one per file; `law_registry.LAWS` lists the laws.

All kernels take and return floats and arrays in SI units.
"""
