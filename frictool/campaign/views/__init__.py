"""Findings for people, pages and programs."""
