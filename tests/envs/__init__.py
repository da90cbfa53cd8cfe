"""Other environments than this one: linear algebra of other processors, the lowest and the newest
dependencies (`make test-envs`)."""
