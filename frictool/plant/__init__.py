"""What surrounds the friction: drive, encoder, backlash; and the plant in the forms that synthesis
needs."""
