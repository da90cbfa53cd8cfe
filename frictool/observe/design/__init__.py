"""Design of observers from a model; each design is verified before its document is written."""
