"""Option --layout: properties of a raw file that its content does not show.

The option replaces the key `layout` of bench.yaml where a log is read without a bench.yaml.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.errors import InputFileError, LogError

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

OPTION = "--layout"
# advice to write a key of `layout` into bench.yaml
_ADVICE = re.compile(r"(?:write )?layout\.\w.*? in bench\.yaml")
# key, and value if the advice contains it; a value with a blank is quoted
_KEY = re.compile(r"layout\.(\w+)(?:: (?:'([^']+)'|([\w-]+)))?")

layout_option = click.option(
    OPTION,
    "layout_texts",
    multiple=True,
    metavar="KEY=VALUE",
    help=(
        "Property of the file that its content does not show reliably, such as "
        "dates=day-first or whole=true. The key layout of bench.yaml has the same keys. Repeatable."
    ),
)


@contextmanager
def layout_advice() -> Iterator[None]:
    """Make LogErrors in the with block advise --layout instead of the key `layout` of a bench."""
    try:
        yield
    except LogError as error:
        error.args = (_ADVICE.sub(_as_option, str(error)),)
        raise


def _as_option(advice: re.Match[str]) -> str:
    keys = advice[0].replace("write ", "use ").removesuffix(" in bench.yaml")
    return _KEY.sub(_option, keys)


def _option(key: re.Match[str]) -> str:
    return f"{OPTION} '{key[1]}={key[2]}'" if key[2] else f"{OPTION} {key[1]}={key[3] or 'VALUE'}"


def layout_of(texts: tuple[str, ...]) -> Layout | None:
    """Return the layout that the `KEY=VALUE` texts of the option state; None if there are no texts.

    Raises click.UsageError if a key is unknown or occurs twice, or if a value is not allowed.
    """
    from yaml import MappingNode, Node

    from frictool.documents.bench import Layout
    from frictool.documents.document_reader import DocumentReader
    from frictool.documents.document_text import compose

    if not texts:
        return None
    reader = DocumentReader(Path(OPTION))
    entries: list[tuple[Node, Node]] = []
    try:
        for text in texts:
            key, sign, value = text.partition("=")
            if not sign:
                raise click.UsageError(f"{OPTION}: found {text!r}; allowed: KEY=VALUE.")
            node = compose(f"{key.strip()}: {value.strip()}", reader.path)
            entries += node.value if isinstance(node, MappingNode) else []
        # an error about the whole mapping states the position of the first key
        start = entries[0][0].start_mark
        layout: Layout = reader.read(
            MappingNode("tag:yaml.org,2002:map", entries, start, start), Layout, ""
        )
    except InputFileError as error:
        reason = str(error).removeprefix(f"{OPTION}:1: ").removeprefix("layout: ")
        raise click.UsageError(f"{OPTION} {reason}.") from None
    return layout
