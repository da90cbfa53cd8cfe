"""Source distribution and wheel, the same bytes from the same commit wherever they are built."""
