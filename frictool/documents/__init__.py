"""Types of the YAML documents that commands read and write, with strict reading and writing.

`identify` turns a `bench` into a `model`. `synth` turns the model, a `spec` and a `design` into a
`controller`. `simulate` simulates a `scenario` with the controller and writes logs. `report` judges
these logs.
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
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "bench": ["Bench"],
            "controller": ["Controller"],
            "design": ["Design"],
            "friction": ["Friction"],
            "mechanism": ["Mechanism"],
            "model": ["Model"],
            "observer": ["Observer"],
            "provenance": ["Provenance"],
            "registry": ["DOCUMENTS", "json_schema", "load"],
            "scenario": ["Scenario"],
            "spec": ["Spec"],
            "writing": ["save", "to_yaml"],
        },
    )
