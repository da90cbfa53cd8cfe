"""Long statistical and stress checks, `make accept`.

Each check_*.py here defines CHECKS: name -> function that returns {"passed": bool, and its
figures}.
"""
