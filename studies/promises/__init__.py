"""Ten benches whose optimal tests are played and identified, to compare with their promise."""
