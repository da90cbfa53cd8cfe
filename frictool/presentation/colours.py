"""Colours of the texts and lines of all figures."""

INK, MUTED, GRID = "#1d2733", "#6b7785", "#e3e7ec"
