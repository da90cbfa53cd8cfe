"""What runs at every sample on the target: one block per file, composed from a controller
document."""
