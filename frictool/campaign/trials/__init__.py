"""Draws played and judged, kept as they come; the search for the worst one."""
