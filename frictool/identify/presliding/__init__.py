"""Presliding laws (thesis 2.4.3) from slow effort loops below breakaway; one module per law."""
