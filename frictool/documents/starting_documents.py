"""Commented starting documents for a new rig. Values that were guessed from a log are marked."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import msgspec
import yaml

from frictool.documents.quantity import Axis, drive_dimension, si_unit

if TYPE_CHECKING:
    import jinja2

    from frictool.documents.bench import Layout

FILES = {
    "bench.yaml": "bench.yaml.jinja",
    "spec.yaml": "spec.yaml.jinja",
    "designs/automatic.yaml": "automatic.yaml.jinja",
    "scenarios/steps.yaml": "steps.yaml.jinja",
    "Makefile": "Makefile.jinja",
}
COLUMNS = {
    "rotary": {"time": ("time", "s"), "position": ("encoder", "count")},
    "linear": {"time": ("time", "s"), "position": ("position", "m")},
}
DRIVES: dict[str, Literal["current", "voltage"]] = {"rotary": "current", "linear": "voltage"}
CONSTANTS = {
    ("rotary", "current"): 13.4e-3,
    ("rotary", "voltage"): 0.1,
    ("linear", "current"): 20.0,
    ("linear", "voltage"): 35.0,
}
NOTE = "\0"  # separates a rendered line from its note
NOTE_COLUMN = 36
EXAMPLE = "example: replace"


@dataclass(frozen=True)
class StartingRig:
    """Facts about a rig that are known from the user or from a log.

    log: base name of the log.
    log_path: path of the log, relative to the rig's folder.
    columns: (column, unit) of each channel.
    left: columns that were assigned to no channel.
    unreadable: reason why a column in `left` cannot be read, by column.
    period: sample period [s].
    step: step of the encoder [rad | m].
    axis_source: source of the kind of axis: the user, the log, or neither.
    questions: note on a column or unit that the log does not contain, by channel.
    percent: channels whose column is in per cent of a full scale that the log does not contain.
    preset: drive or robot whose log format has these columns; it determines the units.
    layout: layout of the log, from the user.
    """

    name: str
    axis: Axis
    log: str | None = None
    log_path: str | None = None
    drive: Literal["current", "voltage"] | None = None
    columns: dict[str, tuple[str, str]] = field(default_factory=dict)
    left: tuple[str, ...] = ()
    unreadable: dict[str, str] = field(default_factory=dict)
    period: float | None = None
    step: float | None = None
    axis_source: Literal["given", "guessed", "example"] = "given"
    questions: dict[str, str] = field(default_factory=dict)
    percent: tuple[str, ...] = ()
    preset: str | None = None
    layout: Layout | None = None


def starting_documents(start: StartingRig) -> dict[str, str]:
    """Return the text of each file in the rig's folder; the keys are file names.

    The files are bench, specification, design, scenario, and a Makefile that chains the commands.
    """
    return {name: _aligned(_listed(text)) for name, text in _rendered(start).items()}


def example_keys(start: StartingRig) -> dict[str, list[str]]:
    """Return, for each file name, the keys with example values; dots separate nested keys.

    The files mark these keys `# example: replace`.
    """
    by_document = {name: _example_keys(text) for name, text in _rendered(start).items()}
    return {name: keys for name, keys in by_document.items() if keys}


def _listed(text: str) -> str:
    keys = _example_keys(text)
    if not keys:
        return text
    rows = "".join(f"  - {key}\n" for key in keys)
    head = f"examples:{NOTE}# unknown for your rig: delete a key when you have replaced its value\n"
    return re.sub(
        r"^name: .*\n",
        lambda name_line: f"{name_line[0]}{head}{rows}",
        text,
        count=1,
        flags=re.MULTILINE,
    )


def _example_keys(text: str) -> list[str]:
    keys: list[str] = []
    parents: list[tuple[int, str]] = []
    for line in text.splitlines():
        before, _, note = line.partition(NOTE)
        if key := re.match(r"( *)(\w+):", before):
            indent = len(key[1])
            parents = [*(parent for parent in parents if parent[0] < indent), (indent, key[2])]
            if note.startswith(f"# {EXAMPLE}"):
                keys.append(".".join(name for _, name in parents))
    return keys


def _rendered(start: StartingRig) -> dict[str, str]:
    context = _context(start)
    environment = _environment()
    return {
        name: environment.get_template(template).render(context) for name, template in FILES.items()
    }


@cache
def _environment() -> jinja2.Environment:
    import jinja2

    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,
    )


def _context(start: StartingRig) -> dict[str, Any]:
    rotary = start.axis == "rotary"
    drive = start.drive or DRIVES[start.axis]
    unit = si_unit(drive, start.axis)

    def note(text: str = "", *, guessed: object = None, example: bool = False) -> str:
        origin = (
            f"guessed from {comment_text(start.log or '')}: check"
            if guessed
            else EXAMPLE
            if example
            else ""
        )
        return f"{NOTE}# {'; '.join(part for part in (origin, text) if part)}"

    return {
        **{
            name: getattr(start, name)
            for name in (
                "name",
                "axis",
                "axis_source",
                "log_path",
                "period",
                "step",
                "left",
                "unreadable",
                "questions",
                "percent",
                "preset",
            )
        },
        "columns": start.columns or {**COLUMNS[start.axis], drive: (drive, unit)},
        "known": bool(start.columns),
        "layout": None if start.layout is None else _flow(msgspec.to_builtins(start.layout)),
        "drive": drive,
        "drive_unit": unit,
        "current": drive == "current",
        "rotary": rotary,
        "position_unit": si_unit("position", start.axis),
        "effort": "torque" if rotary else "force",
        "constant": CONSTANTS[start.axis, drive],
        "constant_unit": si_unit(drive_dimension(drive, constant=True), start.axis),
        "quoted": quoted,
        "comment": comment_text,
        "number": lambda value: repr(float(value)),
        "note": note,
    }


def _aligned(text: str) -> str:
    lines = (line.partition(NOTE) for line in text.splitlines())
    return "".join(
        (f"{before:{NOTE_COLUMN}}  {note}" if note else before) + "\n" for before, _, note in lines
    )


def _flow(value: dict[str, Any]) -> str:
    return yaml.safe_dump(
        value, default_flow_style=True, width=float("inf"), allow_unicode=True, sort_keys=False
    ).rstrip("\n")


def quoted(text: str) -> str:
    """Return a text as a YAML scalar on one line; the scalar is also valid between braces.

    The scalar is put in double quotes, with escapes, unless YAML reads the plain text as the same
    text.
    """
    plain = yaml.safe_dump(
        [text], default_flow_style=True, width=float("inf"), allow_unicode=True
    ).rstrip("\n")[1:-1]
    return plain if plain == text and text.isprintable() else _double_quoted(text)


def _double_quoted(text: str) -> str:
    return yaml.safe_dump(
        text, default_style='"', width=float("inf"), allow_unicode=text.isprintable()
    ).rstrip("\n")


def comment_text(text: str) -> str:
    """Return the text with `?` for unprintable characters, so that a comment stays on one line."""
    return "".join(character if character.isprintable() else "?" for character in text)
