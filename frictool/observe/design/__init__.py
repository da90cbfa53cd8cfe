"""Design of observers from a model, with verification before they are written."""
