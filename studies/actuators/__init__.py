"""Random actuators that are feasible by construction, and a judge that is independent of frictool.

    python -m studies.actuators COUNT --seed TEXT -o table.json

`drawing.py` draws actuators, `documents.py` writes them as model, specification and scenario.
`judge.py` simulates exported controllers with `axis.c` and computes their figures (`figures.c`) and
margins (`margin.py`). `search.py` says which actuators a simple controller (`cascade.c`) solves.
"""
