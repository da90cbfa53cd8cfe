"""Presliding laws (thesis 2.4.3), fitted to slow effort loops below breakaway; one module a law."""
