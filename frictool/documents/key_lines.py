"""Where a key stands in a document's file: what was read is checked again later, against other
documents."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import yaml

from frictool.documents.reading import compose, read_text
from frictool.errors import DocumentError, FrictoolError, InputFileError


def line_of(path: Path, key: str) -> int | None:
    """The line of `key` (`steps[1].reference`) in the document at `path`, or of the last part of it
    that is there.

    None where the document cannot be read again.
    """
    try:
        node = compose(read_text(path), path)
    except InputFileError:
        return None
    line = node.start_mark.line + 1
    for name, index in re.findall(r"([^.\[\]]+)|\[(\d+)\]", key):
        found = _within(node, name, index)
        if found is None:
            break
        line, node = found
    return line


def document_error(name: Path | str, key: str, message: str) -> DocumentError:
    """What is wrong with `key` of the document called `name`, with its line where that is a
    file."""
    line = line_of(Path(name), key) if Path(name).is_file() else None
    return DocumentError(name, message, line=line, key=key)


def in_file(error: FrictoolError, paths: Mapping[str, Path]) -> FrictoolError:
    """Return the error with the file and the line of its key before its message; paths: of the
    documents, by their names."""
    if error.document_key is None or error.document_key[0] not in paths:
        return error
    document, key = error.document_key
    line = line_of(paths[document], key)
    error.args = (f"{paths[document]}{'' if line is None else f':{line}'}: {error}",)
    return error


def _within(node: yaml.Node, name: str, index: str) -> tuple[int, yaml.Node] | None:
    """The line and the value of a key of a mapping, or of an item of a list."""
    if name and isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if key.value == name:
                return key.start_mark.line + 1, value
    if index and isinstance(node, yaml.SequenceNode) and int(index) < len(node.value):
        item = node.value[int(index)]
        return item.start_mark.line + 1, item
    return None
