"""Exported C on a Cortex-M4: self-tests in every build, and the controller in a timer interrupt."""
