"""From the bench logs of an actuator with dry friction to a verified robust controller."""

# a literal: reading the metadata of the installed package takes longer than some commands
__version__ = "0.1.0"
