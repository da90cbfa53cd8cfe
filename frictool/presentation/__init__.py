"""Page frame, figures, decimation and ties of printed figures, for every stage."""
