"""What the logs tell of the bench itself: the width of its backlash, the delay between its
channels, the lag of its current loop."""
