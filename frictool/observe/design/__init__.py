"""Design of observers from a model; a design is verified before it is written."""
