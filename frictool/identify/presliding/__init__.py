"""Presliding laws from slow effort loops below the breakaway (2.4.3, 7.2); one module per law."""
