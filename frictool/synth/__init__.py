"""Model, specification and design to a controller that was verified."""
