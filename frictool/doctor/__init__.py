"""The state of an installation: versions, compiled kernels, solver, C compiler, machine; each
tried, not only looked for."""
