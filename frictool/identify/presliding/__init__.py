"""Presliding from slow loops of the effort below the breakaway (2.4.3, 7.2): one law a file, and
what they have in common."""
