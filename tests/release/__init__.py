"""The source distribution and the wheel."""
