"""Registry of the documents: loading by name, and JSON Schemas for editors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar, cast, overload

import msgspec
import yaml

from frictool.documents.bench import Bench
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.document_reader import DocumentReader
from frictool.documents.document_text import compose, read_text
from frictool.documents.example_values import examples_of
from frictool.documents.friction import Friction
from frictool.documents.key_meanings import meanings_of, structs_of, summary_of
from frictool.documents.mechanism import Mechanism
from frictool.documents.missing_effects import missing_effects
from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.promise import Promise
from frictool.documents.proof import Proof
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.errors import DocumentError, InputFileError
from frictool.runtime import notifications

DOCUMENTS: dict[str, type[msgspec.Struct]] = {
    "bench": Bench,
    "model": Model,
    "spec": Spec,
    "design": Design,
    "controller": Controller,
    "scenario": Scenario,
    "friction": Friction,
    "observer": Observer,
    "mechanism": Mechanism,
    "promise": Promise,
    "proof": Proof,
}

T = TypeVar("T", bound=msgspec.Struct)


@overload
def load(path: Path | str, kind: type[T]) -> T: ...


@overload
def load(path: Path | str) -> Any: ...


def load(path: Path | str, kind: type[T] | None = None) -> T | Any:
    """Load the document at `path`, with every quantity in SI.

    Parameters
    ----------
    path : Path or str
        The YAML file.
    kind : type, optional
        The expected type of document. By default the key `format` of the document determines the
        type.

    Returns
    -------
    T
        The document, an instance of `kind`.

    Raises
    ------
    DocumentError
        If a key or value is wrong; the message names file, line, key, value and allowed values.
    InputFileError
        If the file cannot be read as YAML text.
    """
    path = Path(path)
    node = compose(read_text(path), path)
    document = cast(T, DocumentReader(path).read(node, kind or _kind(node, path), ""))
    if keys := examples_of(document):
        notifications.example_values(str(path), keys)
    if isinstance(document, Model):
        if document.bench_values_only is not None:
            notifications.bench_values(str(path), document.bench_values_only)
        for text in missing_effects(document):
            notifications.missing_effect(str(path), text)
    return document


def _kind(node: yaml.Node, path: Path) -> type[msgspec.Struct]:
    for key, value in node.value if isinstance(node, yaml.MappingNode) else []:
        if key.value == "format":
            document_kind = DOCUMENTS.get(str(value.value).partition("/")[0])
            if document_kind is not None:
                return document_kind
            allowed = ", ".join(f"{name}/1" for name in DOCUMENTS)
            raise DocumentError(
                path,
                f"found {value.value!r}; allowed: {allowed}",
                line=value.start_mark.line + 1,
                key="format",
            )
    raise DocumentError(
        path, "missing; write the kind of document, such as format: bench/1", line=1, key="format"
    )


def same_axis(documents: dict[Path, Any]) -> None:
    """Raise InputFileError if the documents differ in the kind of axis or of drive."""
    for name in ("axis", "drive"):
        axes = {
            path: getattr(document, name)
            for path, document in documents.items()
            if hasattr(document, name)
        }
        first = next(iter(axes.items()), None)
        for path, value in axes.items():
            if first is not None and value != first[1]:
                raise InputFileError(
                    path,
                    f"{name}: found {value}, but {first[0]} has {first[1]}; the documents of "
                    "one rig must agree",
                )


def json_schema(name: str, choices: Mapping[str, Iterable[str]] | None = None) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a document.

    - name: key of `DOCUMENTS`, such as `bench`; KeyError if there is no such document
    - choices: allowed values by type and key, such as `FrictionOf.law`, if another package lists
      them
    """
    schema = msgspec.json.schema(DOCUMENTS[name])
    for kind in structs_of(DOCUMENTS[name]):
        described = schema["$defs"][kind.__name__]
        described["description"] = summary_of(kind)
        for key, meaning in meanings_of(kind).items():
            described["properties"][key]["description"] = meaning
    for path, allowed in (choices or {}).items():
        owner, key = path.split(".")
        schema["$defs"][owner]["properties"][key]["enum"] = list(allowed)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"{name}.yaml",
        **schema,
    }
