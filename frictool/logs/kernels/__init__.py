"""The compiled loops of this room: from bytes to numbers."""
