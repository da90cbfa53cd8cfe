"""A mechanism document as arrays (plant/mechanism/packed_mechanism.py), checked."""
