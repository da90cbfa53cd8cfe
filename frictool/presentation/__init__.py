"""Page frame, figures, tables, decimation and the rule for ties, common to all stages."""
