"""Text of a document file, and its tree of YAML nodes.

Errors name the file, and the line of the first syntax error.
"""

from __future__ import annotations

from pathlib import Path

import yaml

from frictool.documents import yaml_parser
from frictool.errors import InputFileError

MAX_BYTES = 2_000_000


def read_text(path: Path) -> str:
    """Return the text of a document file. Raises InputFileError if it cannot be read as text."""
    try:
        if path.is_dir():
            raise InputFileError(path, "is a directory; a YAML document is expected")
        if not path.is_file() and path.exists():
            raise InputFileError(path, "is not a regular file; a YAML document is expected")
        if path.stat().st_size > MAX_BYTES:
            raise InputFileError(
                path,
                f"has {path.stat().st_size} bytes; allowed: at most {MAX_BYTES}; a YAML "
                "document is expected",
            )
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputFileError(path, "no such file") from None
    except OSError as error:
        raise InputFileError(path, f"cannot be read: {error.strerror}") from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputFileError(
            path, f"is not text (byte {error.start} is not UTF-8); a YAML document is expected"
        ) from None
    if not text.strip():
        raise InputFileError(path, "is empty; a YAML document is expected")
    return text


def compose(text: str, path: Path) -> yaml.Node:
    """Parse the text of a document and return the root of its tree of YAML nodes.

    Raises InputFileError with the line of the first syntax error.
    """
    try:
        node = yaml_parser.compose(text)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = (
            _problem(error)
            if isinstance(error, yaml_parser.RefusedYaml)
            else f"not valid YAML: {_problem(error)}"
        )
        raise InputFileError(path, problem, line=None if mark is None else mark.line + 1) from None
    except (yaml.YAMLError, ValueError) as error:
        raise InputFileError(path, f"not valid YAML: {str(error).splitlines()[0]}") from None
    except RecursionError:
        raise InputFileError(path, "not valid YAML: nested too deeply") from None
    if node is None:
        raise InputFileError(path, "is empty; a YAML document is expected")
    return node


def is_format(path: Path, name: str) -> bool:
    """Return True if the document at `path` has the format `name`, in any version.

    Raises InputFileError if the file is not a document.
    """
    node = compose(read_text(path), path)
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    return any(
        key.value == "format" and str(value.value).startswith(f"{name}/") for key, value in pairs
    )


def _problem(error: yaml.MarkedYAMLError) -> str:
    problem = error.problem or error.context or "?"
    if "'\\t'" in problem:
        return "found a tab; indent with spaces"
    return (
        "found a second document, after ---; a file contains one document"
        if "another document" in problem
        else problem
    )
