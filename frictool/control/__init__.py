"""Blocks of controllers and observers, and the programs that execute them at every sample."""
