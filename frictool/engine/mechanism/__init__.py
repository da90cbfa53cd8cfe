"""Moves a mechanism of many blocks through time: rigid links exact, stick and contact in several
places at once, event by event."""
