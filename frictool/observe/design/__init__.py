"""Design of observers from a model; each design is verified before it is written."""
