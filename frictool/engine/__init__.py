"""Moves a plant and its sampled controller through time: events, closed loop, batches."""
