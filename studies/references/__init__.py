"""Independent solutions, slow and plain, against which the engine and the solvers are held."""
