"""From a record to rows of regressors: strokes, slip, filters and differences, all signals at one
instant."""
