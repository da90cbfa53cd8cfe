"""Linear matrix inequalities: formulation, balancing and solution."""
