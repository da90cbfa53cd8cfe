"""The equations of a mechanism, derived from its description: symbols, sums of products, their dimensions, what is eliminated."""
