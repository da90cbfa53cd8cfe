"""`spec.yaml`: requirements of the closed loop; each key is one requirement of the verdict."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import msgspec

from frictool.documents.bench import Name
from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.quantity import Axis
from frictool.runtime.object_view import ObjectView


class SpecHead(
    ObjectView, msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Keys of a specification that are not requirements."""

    format: Literal["spec/1"]
    name: Name
    axis: Axis
    drive: Literal["current", "voltage"]


SUMMARY = """Requirements on the closed loop: `spec.yaml`. Each key is one requirement, except \
`format`, `name`, `axis`, `drive` and `examples`.

docs/metrics.md defines each metric.
"""

if TYPE_CHECKING:

    class Spec(SpecHead, frozen=True):
        """Requirements of a closed loop: `spec.yaml`.

        The fields are those of SpecHead, and the keys of REQUIREMENTS. An absent field is None.
        """

        examples: tuple[str, ...]

        def __init__(self, **keys: Any) -> None: ...
        def __getattr__(self, key: str) -> Any: ...

else:
    meanings = (f"- `{key}`: {metric.meaning}" for key, metric in REQUIREMENTS.items())
    Spec = msgspec.defstruct(
        "Spec",
        [
            *((key, metric.limit | None, None) for key, metric in REQUIREMENTS.items()),
            ("examples", tuple[str, ...], ()),
        ],
        bases=(SpecHead,),
        module=__name__,
        namespace={"__doc__": "\n".join([SUMMARY, *meanings])},
        frozen=True,
        forbid_unknown_fields=True,
        omit_defaults=True,
    )
