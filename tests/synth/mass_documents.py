"""Model, specification and designs of configs/mass."""

from __future__ import annotations

from typing import Any

import msgspec

from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from studies.rigs.clutch_model import ROOT

RIG = ROOT / "configs/mass"


def design(name: str, **changes: Any) -> Design:
    return msgspec.structs.replace(load(RIG / f"designs/{name}.yaml", Design), **changes)


def model(name: str = "model") -> Model:
    return load(RIG / f"{name}.yaml", Model)


def spec() -> Spec:
    return load(RIG / "spec.yaml", Spec)
