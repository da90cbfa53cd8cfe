"""The canonical log: MCAP, its writer and its reader side by side."""
