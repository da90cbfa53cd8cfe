"""Factors that a campaign varies, draws of their values, and the scenario of each draw."""
