"""Mechanisms of blocks and links (thesis 2.1): assembly into arrays, and linearisation."""
