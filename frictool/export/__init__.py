"""A controller as source code with golden vectors."""
