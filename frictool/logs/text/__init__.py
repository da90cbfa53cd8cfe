"""Text: CSV and its kin, as instruments write it."""
