"""Time-domain simulation of a plant with its sampled controller: events, closed loop, batches."""
