"""Friction laws and hysteresis operators, one per file; `law_registry.LAWS` lists the laws.

Their kernels take and return SI floats and arrays.
"""
