"""The reference pages of commands and documents, written from the program: `make reference`.

docs/reference/commands.md follows click's commands, docs/reference/documents.md the types of the
documents.
"""

from __future__ import annotations

import re
import sys
import typing
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

import click
import msgspec
import yaml

from frictool.cli.main import COMMANDS, EXIT_CODES, group
from frictool.documents.key_meanings import meanings_of, structs_of, summary_of
from frictool.documents.quantity import CHOICES, SI_UNITS, Estimate, Quantity, Series, Span
from frictool.documents.registry import DOCUMENTS

WRITTEN = "This page is written from the program by `make reference`; do not edit it."
SHARED = {Quantity: "quantity", Estimate: "estimate", Span: "range", Series: "series"}
SCALARS = {float: "number", int: "whole number", str: "text", bool: "true or false"}
UNITS = {  # end of a key's name -> unit of its number
    "rad_s": "rad/s",
    "_per_s": "1/s",
    "_hz": "Hz",
    "_deg": "deg",
    "_percent": "%",
    "_ohm": "ohm",
    "_v": "V",
    "_s": "s",
    "_samples": "samples",
    "_bits": "bits",
}
DRIVES = {"drive": "A, V", "effort per drive": "N m/A, N/A, N m/V, N/V", "any": "any"}


def pages() -> dict[str, str]:
    """Return the text of each page by its file name."""
    return {"commands.md": commands_page(), "documents.md": documents_page()}


def _table(head: str, rows: list[list[str]]) -> str:
    cells = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    lines = [f"| {head} |", "|" + " --- |" * (head.count("|") + 1)]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in cells)]) + "\n"


def _split_unit(text: str) -> tuple[str, str]:
    """Return the unit in brackets that a text contains once, and the text without it."""
    found = re.findall(r"(?<=\w) \[([^\],:=]+)\]", text)
    if len(found) != 1:
        return "", text
    return found[0].replace(" | ", ", "), text.replace(f" [{found[0]}]", "")


def anchor_of(heading: str) -> str:
    """Return the anchor that GitHub gives to a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


# documents


def documents_page() -> str:
    """Return docs/reference/documents.md."""
    headings: dict[Any, str] = dict(SHARED)
    parts = [
        f"# Keys of the documents\n\n{WRITTEN} [Documents](../formats.md) explains how they belong "
        "together.\n\nA number with a suffix such as `_s` or `_rad_s` is in that unit. A quantity "
        "is written with its unit; the column names the SI units of a rotary and of a linear "
        "axis, and any multiple is allowed. `required` marks a key without a default; another key "
        "without a default may be left out.\n\n## Quantities\n"
    ]
    for kind, name in SHARED.items():
        parts.append(_struct(kind, f"### {name}", headings))
    texts: dict[str, str] = {}
    for name in DOCUMENTS:
        _document(name, headings, texts)
    return "\n".join([*parts, *(texts[name] for name in DOCUMENTS)])


def _document(name: str, headings: dict[Any, str], texts: dict[str, str]) -> None:
    """Add the text of a document to `texts`, after that of the documents which it contains."""
    document = DOCUMENTS[name]
    contained = structs_of(document)
    for other, kind in DOCUMENTS.items():
        if other != name and kind in contained:
            _document(other, headings, texts)
    if name in texts:
        return
    paths: dict[Any, str] = {document: ""}
    for kind in contained:
        for key, hint in typing.get_type_hints(kind, include_extras=True).items():
            for path, struct in _parts(hint, f"{paths[kind]}.{key}".lstrip(".")):
                paths.setdefault(struct, path)
    new = [kind for kind in paths if kind not in headings]
    for kind in new:
        headings[kind] = f"{name}.yaml: {paths[kind]}" if paths[kind] else f"{name}.yaml"
    order = [document, *(kind for kind in contained if kind in new[1:])]
    level = {kind: "##" if kind is document else "###" for kind in order}
    texts[name] = "\n".join(
        _struct(kind, f"{level[kind]} {headings[kind]}", headings) for kind in order
    )


def _parts(hint: Any, path: str) -> list[tuple[str, Any]]:
    """Return the structs directly in a type, each with its path in the document."""
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        tag = hint.__struct_config__.tag
        return [(f"{path} (kind: {tag})" if tag else path, hint)]
    steps = {dict: f"{path}.NAME", tuple: f"{path}[]"}
    below = steps.get(get_origin(hint), path)
    return [found for part in get_args(hint) for found in _parts(part, below)]


def _struct(kind: Any, heading: str, headings: dict[Any, str]) -> str:
    hints = typing.get_type_hints(kind, include_extras=True)
    meanings = meanings_of(kind)
    rows = []
    if (config := kind.__struct_config__).tag_field:
        rows.append([f"`{config.tag_field}`", "text", "", "required", f"`{config.tag}`", "Type."])
    for field in msgspec.structs.fields(kind):
        type_text, unit, allowed = _described(hints[field.name], headings)
        bracket, meaning = _split_unit(meanings[field.name])
        suffix = next((u for end, u in UNITS.items() if field.name.endswith(end)), "")
        rows.append(
            [
                f"`{field.encode_name}`",
                type_text,
                unit or bracket or (suffix if "number" in type_text else ""),
                _default(field),
                allowed,
                meaning if not unit else meanings[field.name],
            ]
        )
    table = _table("key | type | unit | default | allowed | meaning", rows)
    return f"{heading}\n\n{summary_of(kind)}\n\n{table}"


def _default(field: msgspec.structs.FieldInfo) -> str:
    if field.required or field.name == "unit":
        return "required"
    value = field.default
    if field.default_factory is not msgspec.NODEFAULT:
        value = field.default_factory()
    if value is None:
        return ""
    text = yaml.safe_dump(msgspec.to_builtins(value), default_flow_style=True)
    return f"`{text.removesuffix(chr(10)).removesuffix(chr(10) + '...')}`"


def _described(hint: Any, headings: dict[Any, str]) -> tuple[str, str, str]:
    """Return type, unit and allowed values of a key."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        described = _described(args[0], headings)
        bounds = [bound for meta in args[1:] for bound in _bounds(meta)]
        unit = next((_unit(meta.extra["dimension"]) for meta in args[1:] if meta.extra), "")
        allowed = "; ".join(filter(None, [described[2], " and ".join(bounds)]))
        return described[0], unit or described[1], allowed
    if origin is Literal:
        return SCALARS[type(args[0])], "", ", ".join(f"`{value}`" for value in args)
    if origin is dict:
        key, value = _described(args[0], headings), _described(args[1], headings)
        keys = f"keys: {key[2]}" if key[2] else ""
        return (
            f"map of names to {_plural(value[0])}",
            value[1],
            "; ".join(filter(None, [keys, value[2]])),
        )
    if origin is tuple:
        described = _described(args[0], headings)
        count = "list of" if args[-1] is Ellipsis else f"list of {len(args)}"
        return f"{count} {_plural(described[0])}", described[1], described[2]
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        text = SHARED.get(hint) or f"{hint.__struct_config__.tag or 'keys'}"
        return f"[{text}](#{anchor_of(headings[hint])})", "", ""
    if args:  # a union
        parts = [_described(arg, headings) for arg in args if arg is not type(None)]
        joined = [
            ", ".join(dict.fromkeys(filter(None, texts))) for texts in zip(*parts, strict=True)
        ]
        return (
            joined[0].replace(", ", " or ") if len(parts) < 3 else joined[0],
            joined[1],
            joined[2],
        )
    return SCALARS[hint], "", ""


def _plural(text: str) -> str:
    return f"{text}s" if text.endswith("number") else text


def _bounds(meta: msgspec.Meta) -> list[str]:
    pairs = [(">", meta.gt), (">=", meta.ge), ("<", meta.lt), ("<=", meta.le)]
    if meta.extra and meta.extra["minimum"] is not None:
        pairs.append((">" if meta.extra["exclusive"] else ">=", meta.extra["minimum"]))
    bounds = [f"{relation} {bound:g}" for relation, bound in pairs if bound is not None]
    if meta.max_length is not None:
        bounds.append(f"length {meta.min_length or 0} to {meta.max_length}")
    elif meta.min_length is not None:
        bounds.append(f"length at least {meta.min_length}")
    return bounds


def _unit(dimension: str) -> str:
    if dimension in CHOICES:
        units = [SI_UNITS[name][axis == "linear"] for name, axis in CHOICES[dimension]]
    else:
        units = list(SI_UNITS.get(dimension, (DRIVES.get(dimension, ""),)))
    return ", ".join(dict.fromkeys(units))


# commands


def commands_page() -> str:
    """Return docs/reference/commands.md."""
    parts = [
        f"# Commands\n\n{WRITTEN} `frictool COMMAND --help` prints the same. Every command has "
        f"`--help`, and `frictool --debug COMMAND` shows the traceback of an error.\n\n"
        f"## Exit codes\n\n```text\n{EXIT_CODES}\n```\n"
    ]
    context = click.Context(group, info_name="frictool")
    for name in COMMANDS:
        command = group.get_command(context, name)
        assert command is not None
        parts += _command(command, click.Context(command, context, name), "##")
    return "\n".join(parts)


def _command(command: click.Command, context: click.Context, level: str) -> list[str]:
    path = context.command_path.removeprefix("frictool ")
    usage = " ".join([context.command_path, *command.collect_usage_pieces(context)])
    parts = [f"{level} {path}\n\n```text\n{usage}\n```\n\n{_prose(command.help or '')}\n"]
    arguments = [p for p in command.params if isinstance(p, click.Argument)]
    options = [p for p in command.params if isinstance(p, click.Option)]
    if arguments:
        rows = [[f"`{p.human_readable_name}`", *_type(p.type), p.help] for p in arguments]  # type: ignore[attr-defined]  # cli/arguments.py
        parts.append(_table("argument | type | allowed | meaning", rows))
    if options:
        head = "option | type | unit | default | allowed | meaning"
        parts.append(_table(head, [_option(option, context) for option in options]))
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            assert below is not None
            parts += _command(below, click.Context(below, context, name), "###")
    return parts


def _prose(help_text: str) -> str:
    """Return a help text as Markdown: what click would not wrap becomes a block of text."""
    out = []
    for paragraph in help_text.strip().split("\n\n"):
        if paragraph.startswith("\b\n"):
            title, _, lines = paragraph.removeprefix("\b\n").partition("\n")
            out.append(f"{title}\n\n```text\n{lines}\n```")
        else:
            out.append(" ".join(paragraph.split()))
    return "\n\n".join(out)


def _type(kind: click.ParamType) -> tuple[str, str]:
    """Return type and allowed values of a parameter."""
    if isinstance(kind, click.Choice):
        return "text", ", ".join(f"`{choice}`" for choice in kind.choices)
    if isinstance(kind, click.IntRange | click.FloatRange):
        ends = [
            f"{relation}{'' if end_open else '='} {end:g}"
            for relation, end, end_open in (
                (">", kind.min, kind.min_open),
                ("<", kind.max, kind.max_open),
            )
            if end is not None
        ]
        return SCALARS[int if isinstance(kind, click.IntRange) else float], " and ".join(ends)
    return {"boolean": "flag", "integer": SCALARS[int]}.get(kind.name, kind.name), ""


def _option(option: click.Option, context: click.Context) -> list[str]:
    type_text, allowed = _type(option.type)
    text = " ".join((option.help or "").split())
    default = re.search(r" ?\[default: ([^\]]+)\]", text)
    text = text.replace(default[0], "") if default else text
    unit, text = _split_unit(text)
    value = default[1] if default else ""
    if not default and isinstance(option.default, str | int | float) and not option.is_flag:
        value = f"`{option.default}`"
    names = ", ".join(f"`{name}`" for name in [*option.opts, *option.secondary_opts])
    if option.metavar:
        names += f" `{option.metavar}`"
    kind = f"{type_text}, repeatable" if option.multiple else type_text
    return [names, kind, unit, "required" if option.required else value, allowed, text]


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(exist_ok=True)
    for file, text in pages().items():
        (folder / file).write_text(text, encoding="utf-8")
