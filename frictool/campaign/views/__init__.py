"""Findings of a campaign as text, page, figures, JSON, YAML and CSV."""
