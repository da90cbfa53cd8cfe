"""Varied factors of a campaign, draws from their space, and the scenario of each draw."""
