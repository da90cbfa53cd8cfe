"""Reader and writer of text files: CSV and similar formats of instruments."""
