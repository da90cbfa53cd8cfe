"""Drive, encoder, backlash and mechanism around the friction laws; plant models for synthesis."""
