"""Controllers and observers as they run at every sample on the target.

Each block has its own file; a controller document says how they are composed.
"""
