"""From a mechanism to the one-inertia model, step by step, each with what it neglects and the error that it makes (thesis 2.1.5, 2.2.4)."""
