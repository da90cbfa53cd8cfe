"""Plain scalars of YAML 1.2's core schema (numbers, true, false and null), for reading and writing.

PyYAML follows YAML 1.1 by default, in which `1e-5` is text and `no` is false.
"""

from __future__ import annotations

import re

import yaml

_SCALARS = (
    ("bool", r"^(?:true|false)$", ("t", "f")),
    ("int", r"^[-+]?[0-9]+$", tuple("-+0123456789")),
    (
        "float",
        r"^[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?$",
        tuple("-+.0123456789"),
    ),
    ("float", r"^(?:[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$", tuple("-+.")),
    ("null", r"^(?:~|null|)$", ("~", "n", "")),
)


class Loader(yaml.SafeLoader):
    """YAML loader that reads plain scalars by the rules of YAML 1.2."""

    yaml_implicit_resolvers: dict[str, list[tuple[str, re.Pattern[str]]]] = {}  # noqa: RUF012  # the library's own attribute


class Dumper(yaml.SafeDumper):
    """YAML dumper that writes scalars so that `Loader` reads the same values."""

    yaml_implicit_resolvers: dict[str, list[tuple[str, re.Pattern[str]]]] = {}  # noqa: RUF012  # as above


for _class in (Loader, Dumper):
    for _tag, _pattern, _first in _SCALARS:
        _class.add_implicit_resolver(
            f"tag:yaml.org,2002:{_tag}", re.compile(_pattern), list(_first)
        )
