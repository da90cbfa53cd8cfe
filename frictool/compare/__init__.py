"""The four tests of thesis 3.7 on every friction law, as numbers and verdicts."""
