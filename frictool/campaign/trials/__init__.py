"""Trials of a campaign: simulation, judgement and storage, and the search for worst cases."""
