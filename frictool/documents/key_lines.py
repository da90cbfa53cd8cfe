"""Line numbers of keys, for errors that are detected after the document was read."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import yaml

from frictool.documents.document_text import compose, read_text
from frictool.errors import DocumentError, FrictoolError, InputFileError


def line_of(path: Path, key: str) -> int | None:
    """Return the line of `key` (such as `steps[1].reference`) in the document at `path`.

    If the key is absent, return the line of the nearest enclosing key that is present. Return None
    if the document cannot be read again.
    """
    try:
        node = compose(read_text(path), path)
    except InputFileError:
        return None
    line = node.start_mark.line + 1
    for name, index in re.findall(r"([^.\[\]]+)|\[(\d+)\]", key):
        node_line = _within(node, name, index)
        if node_line is None:
            break
        line, node = node_line
    return line


def document_error(name: Path | str, key: str, message: str) -> DocumentError:
    """Return an error about `key` of the document `name`, with the line if `name` is a file."""
    line = line_of(Path(name), key) if Path(name).is_file() else None
    return DocumentError(name, message, line=line, key=key)


def in_file(error: FrictoolError, paths: Mapping[str, Path]) -> FrictoolError:
    """Return the error with a message that begins with the file and line of the key.

    `paths` maps the names of documents to their files.
    """
    if error.document_key is None or error.document_key[0] not in paths:
        return error
    document, key = error.document_key
    line = line_of(paths[document], key)
    error.args = (f"{paths[document]}{'' if line is None else f':{line}'}: {error}",)
    return error


def _within(node: yaml.Node, name: str, index: str) -> tuple[int, yaml.Node] | None:
    if name and isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if key.value == name:
                return key.start_mark.line + 1, value
    if index and isinstance(node, yaml.SequenceNode) and int(index) < len(node.value):
        item = node.value[int(index)]
        return item.start_mark.line + 1, item
    return None
