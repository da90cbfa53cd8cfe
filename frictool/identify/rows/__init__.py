"""Conversion of records to regression rows: strokes, slip, filters and differences."""
