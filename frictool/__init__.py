"""From the bench logs of an actuator with dry friction to a verified robust controller."""

from importlib.metadata import version as _version

__version__ = _version("frictool")
