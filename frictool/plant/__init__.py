"""Drive, encoder and backlash around the friction, and the plant in forms for synthesis."""
