"""A mechanism of blocks and links (thesis 2.1): put together from its document, as arrays for the
engine, as equations, linearised."""
