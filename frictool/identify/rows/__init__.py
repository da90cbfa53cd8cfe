"""Convert records to regression rows: strokes, slip, filters and differences at one instant."""
