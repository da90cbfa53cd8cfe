"""Types of the YAML documents that pass between commands, with strict reading and writing.

`identify` turns a `bench` into a `model`. `synth` turns the model, a `spec` and a `design` into a
`controller`. `simulate` plays a `scenario` with it and writes logs, which `report` judges.
"""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.documents.bench import Bench as Bench
    from frictool.documents.controller import Controller as Controller
    from frictool.documents.design import Design as Design
    from frictool.documents.friction import Friction as Friction
    from frictool.documents.mechanism import Mechanism as Mechanism
    from frictool.documents.model import Model as Model
    from frictool.documents.observer import Observer as Observer
    from frictool.documents.provenance import Provenance as Provenance
    from frictool.documents.registry import DOCUMENTS as DOCUMENTS
    from frictool.documents.registry import json_schema as json_schema
    from frictool.documents.registry import load as load
    from frictool.documents.scenario import Scenario as Scenario
    from frictool.documents.spec import Spec as Spec
    from frictool.documents.writing import save as save
    from frictool.documents.writing import to_yaml as to_yaml
else:
    __getattr__, __dir__ = lazy_exports(
        __name__,
        {
            "Bench": "frictool.documents.bench",
            "Controller": "frictool.documents.controller",
            "DOCUMENTS": "frictool.documents.registry",
            "Design": "frictool.documents.design",
            "Friction": "frictool.documents.friction",
            "Mechanism": "frictool.documents.mechanism",
            "Model": "frictool.documents.model",
            "Observer": "frictool.documents.observer",
            "Provenance": "frictool.documents.provenance",
            "Scenario": "frictool.documents.scenario",
            "Spec": "frictool.documents.spec",
            "json_schema": "frictool.documents.registry",
            "load": "frictool.documents.registry",
            "save": "frictool.documents.writing",
            "to_yaml": "frictool.documents.writing",
        },
    )

__all__ = [
    "DOCUMENTS",
    "Bench",
    "Controller",
    "Design",
    "Friction",
    "Mechanism",
    "Model",
    "Observer",
    "Provenance",
    "Scenario",
    "Spec",
    "json_schema",
    "load",
    "save",
    "to_yaml",
]
