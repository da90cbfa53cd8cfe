"""Damping and friction of one joint, written into a copy of a URDF or SDF file.

Only the bytes of the two values change.

    URDF  <joint name="NAME" type="..."> ... <dynamics damping="..." friction="..."/> </joint>
    SDF   <joint name="NAME" type="..."><axis> ... <dynamics><damping/><friction/></dynamics></axis>
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from frictool.documents.model import Model
from frictool.errors import InputFileError
from frictool.export.model_features import left_out_levels, without_features

KINDS = {"rotary": ("revolute", "continuous"), "linear": ("prismatic",)}  # types of joints
CONTAINERS = {"robot", "sdf", "world", "model"}  # elements that contain joints, like xacro's
TAG_END = re.compile(rb"\s*/?>$")


@dataclass
class XmlElement:
    """Element of an XML file, with byte positions in the file.

    - name, attributes: as in the file
    - start, content: positions of the start tag and of the first byte behind it
    - stop, end: positions of the end tag and of the first byte behind it; both equal to `content`
      if the start tag closes the element
    - line: line of the start tag
    """

    name: str
    attributes: dict[str, str]
    start: int
    line: int
    content: int = 0
    stop: int = 0
    end: int = 0
    children: list[XmlElement] = field(default_factory=list)

    def child(self, name: str) -> XmlElement | None:
        """Return the first child of this name; None without such a child."""
        return next((one for one in self.children if one.name == name), None)


def xml_tree(path: Path, data: bytes) -> XmlElement:
    """Return the root element of an XML file.

    Raises InputFileError if the file is not XML, or if its values cannot be replaced byte by byte.
    """
    parser = expat.ParserCreate()
    root = XmlElement("", {}, 0, 1)
    open_elements = [root]

    def refuse(reason: str) -> InputFileError:
        return InputFileError(path, reason, line=parser.CurrentLineNumber)

    def declared(version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None and encoding.upper().startswith(("UTF-16", "UCS", "UTF-32")):
            raise refuse(f"is encoded in {encoding}; save it as UTF-8")

    def entity(*_: object) -> None:
        raise refuse("declares an entity; replace the entities by their text")

    def begin(name: str, attributes: dict[str, str]) -> None:
        start = parser.CurrentByteIndex
        element = XmlElement(name, attributes, start, parser.CurrentLineNumber)
        element.content = element.stop = element.end = _tag_end(data, start)
        open_elements[-1].children.append(element)
        open_elements.append(element)

    def finish(_: str) -> None:
        element = open_elements.pop()
        if data[: element.content].endswith(b"/>"):
            return
        element.stop = parser.CurrentByteIndex
        element.end = data.index(b">", element.stop) + 1

    parser.XmlDeclHandler = declared
    parser.EntityDeclHandler = entity
    parser.StartElementHandler = begin
    parser.EndElementHandler = finish
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputFileError(path, "is encoded in UTF-16; save it as UTF-8")
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise InputFileError(
            path, f"is not well-formed XML: {expat.ErrorString(error.code)}", line=error.lineno
        ) from None
    return root.children[0]


def _tag_end(data: bytes, start: int) -> int:
    quote = 0
    for position in range(start, len(data)):
        byte = data[position]
        if quote:
            quote = 0 if byte == quote else quote
        elif byte in b"\"'":
            quote = byte
        elif byte == ord(">"):
            return position + 1
    return len(data)


def joints(root: XmlElement) -> list[XmlElement]:
    """Return the joints of robots and models, without the joints of transmissions and plugins."""
    found: list[XmlElement] = []
    if root.name in CONTAINERS or root.name.startswith("xacro:"):
        for element in root.children:
            if element.name == "joint":
                found.append(element)
            else:
                found += joints(element)
    return found


def urdf_files(
    model: Model, path: Path, name: str | None, without: Collection[str]
) -> tuple[Mapping[str, str | bytes], list[str]]:
    """Return the robot description with the model's damping and friction, and notes.

    - model: model of the joint; its viscous friction becomes `damping` (N m s/rad | N s/m), its
      Coulomb friction becomes `friction` (N m | N)
    - path: URDF, xacro or SDF file
    - name: name of the joint; None selects the only joint of the model's kind
    - without: features of the model that are left out

    Raises InputFileError if the file is not a robot description or has no such joint. Raises
    NoSolutionError if the model has a feature that a joint's dynamics cannot represent.
    """
    model, notes = without_features(model, "URDF and SDF", (), without)
    notes += left_out_levels(model, "breakaway", "offset")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputFileError(path, f"cannot be read: {error.strerror}") from None
    root = xml_tree(path, data)
    if root.name not in ("robot", "sdf"):
        raise InputFileError(
            path, f"found <{root.name}>; allowed: <robot> (URDF) or <sdf>", line=root.line
        )
    joint = _joint(path, root, model, name)
    values = {"damping": model.parameters.viscous.value, "friction": model.parameters.coulomb.value}
    patched = (_urdf_joint if root.name == "robot" else _sdf_joint)(path, data, joint, values)
    texts = ", ".join(f"{key} {value!r}" for key, value in values.items())
    return {path.name: patched}, [
        f"joint {joint.attributes['name']}, line {joint.line}: {texts}",
        *notes,
    ]


def _joint(path: Path, root: XmlElement, model: Model, name: str | None) -> XmlElement:
    kinds = KINDS[model.axis]
    known = [one for one in joints(root) if "name" in one.attributes]
    movable = [one for one in known if one.attributes.get("type") in kinds]
    names = ", ".join(one.attributes["name"] for one in movable) or "none"
    chosen = movable if name is None else [one for one in known if one.attributes["name"] == name]
    if len(chosen) == 1:
        kind = chosen[0].attributes.get("type", "without type")
        if kind in kinds:
            return chosen[0]
        raise InputFileError(
            path,
            f"joint {name} is {kind}; allowed for a {model.axis} axis: {' or '.join(kinds)}",
            line=chosen[0].line,
        )
    if name is None:
        raise InputFileError(
            path, f"{len(chosen)} {' or '.join(kinds)} joints ({names}); name one with --joint"
        )
    if chosen:
        lines = ", ".join(str(one.line) for one in chosen)
        raise InputFileError(
            path, f"{len(chosen)} joints are called {name} (lines {lines}); rename all but one"
        )
    raise InputFileError(path, f"no joint {name}; found {' or '.join(kinds)} joints: {names}")


def _urdf_joint(path: Path, data: bytes, joint: XmlElement, values: Mapping[str, float]) -> bytes:
    dynamics = joint.child("dynamics")
    if dynamics is None:
        attributes = " ".join(f'{key}="{value!r}"' for key, value in values.items())
        return _appended(path, data, joint, f"<dynamics {attributes}/>")
    tag = data[dynamics.start : dynamics.content]
    for key, value in values.items():
        text = f'{key}="{value!r}"'.encode()
        there = re.search(rf"(?<=\s){key}\s*=\s*(?:\"[^\"]*\"|'[^']*')".encode(), tag)
        if there is not None:
            tag = tag[: there.start()] + text + tag[there.end() :]
        else:
            tag = TAG_END.sub(lambda end, text=text: b" " + text + end.group(), tag)  # type: ignore[misc]
    return data[: dynamics.start] + tag + data[dynamics.content :]


def _sdf_joint(path: Path, data: bytes, joint: XmlElement, values: Mapping[str, float]) -> bytes:
    axis = joint.child("axis")
    if axis is None:
        raise InputFileError(
            path, f"joint {joint.attributes['name']} has no <axis>; add it", line=joint.line
        )
    dynamics = axis.child("dynamics")
    elements = {key: f"<{key}>{value!r}</{key}>" for key, value in values.items()}
    if dynamics is None:
        return _appended(path, data, axis, f"<dynamics>{''.join(elements.values())}</dynamics>")
    if dynamics.stop == dynamics.end:  # <dynamics/>
        text = f"<dynamics>{''.join(elements.values())}</dynamics>"
        return data[: dynamics.start] + text.encode() + data[dynamics.end :]
    for key in reversed(elements):  # from the end of the file: earlier positions stay valid
        there = dynamics.child(key)
        if there is None:
            data = _appended(path, data, dynamics, elements[key])
    changed = [(dynamics.child(key), text) for key, text in elements.items()]
    for there, text in sorted(
        ((one, text) for one, text in changed if one is not None), key=lambda pair: -pair[0].start
    ):
        data = data[: there.start] + text.encode() + data[there.end :]
    return data


def _appended(path: Path, data: bytes, parent: XmlElement, text: str) -> bytes:
    if not parent.children:
        raise InputFileError(
            path,
            f"<{parent.name}> is empty; allowed: at least one element; write its required elements",
            line=parent.line,
        )
    last = parent.children[-1]
    line = data.rfind(b"\n", 0, last.start) + 1
    indent = data[line : last.start]
    line_end = b"\r\n" if data[:line].endswith(b"\r\n") else b"\n"
    # without a line break if the child does not begin its line
    gap = b"" if indent.strip() else line_end + indent
    return data[: last.end] + gap + text.encode() + data[last.end :]
