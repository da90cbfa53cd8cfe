"""Conversion of documents to records of `plant` and `control`, and of records to documents."""
