"""Mechanisms of blocks and links: their arrays, and linearisation."""
