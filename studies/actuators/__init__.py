"""Random feasible actuators, and a judge of controllers that is independent of frictool.

    python -m studies.actuators COUNT --seed TEXT -o table.json

`drawing.py` draws actuators; `documents.py` writes them as model, specification and scenario.
`judge.py` simulates exported controllers with `axis.c` and computes their metrics (`figures.c`) and
margins (`margin.py`). `search.py` finds out for which actuators a simple controller (`cascade.c`)
meets the specification.
"""
