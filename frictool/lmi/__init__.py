"""Matrix inequalities: assembled for the solver, balanced, solved."""
