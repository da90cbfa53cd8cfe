"""Conversion of records to regression rows: strokes, slipping samples, filters, load columns."""
