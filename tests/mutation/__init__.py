"""Mutation testing: small edits of the numerical code, each of which a test has to notice."""
