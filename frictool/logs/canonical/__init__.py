"""Reader and writer of the canonical log, an MCAP file."""
