"""Time-domain simulation of plants with dry friction, with and without a sampled controller."""
