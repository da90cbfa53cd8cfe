"""Page frame, figures, tables and decimation, shared by all stages."""
