"""Parser of message definitions in OMG IDL (`ros2idl`), as ROS 2 writes them."""

from __future__ import annotations

import re
from collections.abc import Iterator

from frictool.logs.recordings.ros_message import (
    NUMBERS,
    TEXTS,
    WELL_KNOWN,
    Definitions,
    MessageType,
    Repeat,
    assembled,
    parse_message,
    short_name,
)

_TOKENS = re.compile(
    r"""
    # comments, directives, separators of the files of a recording
    //[^\n]*|/\*.*?\*/|^[ \t]*\#[^\n]*|^=+[ \t\r]*$|^IDL:[^\n]*
    |(?P<token>@[\w.:]+|"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|[\w.+-]+(?:::\w+)*|[^\s\w])""",
    re.VERBOSE | re.MULTILINE | re.DOTALL,
)
_BASIC = {
    "boolean": "bool", "octet": "byte", "char": "char", "float": "float32", "double": "float64",
    "short": "int16", "long": "int32",
    "long long": "int64", "unsigned short": "uint16", "unsigned long": "uint32",
    "unsigned long long": "uint64",
    **{name: name for name in NUMBERS if name.startswith(("int", "uint"))},
    **{name: name for name in TEXTS},
}  # fmt: skip
Type = tuple[str, Repeat, int]


def parse_idl(name: str, text: str) -> MessageType:
    """Return the message type `name`, such as `sensor_msgs/msg/JointState`, from an IDL text.

    Raises ValueError if the text is not IDL as ROS 2 writes it.
    """
    parser = _IdlParser([match["token"] for match in _TOKENS.finditer(text) if match["token"]])
    parser.definitions(())
    for known, lines in WELL_KNOWN.items():
        definition = parse_message(known, lines)
        parser.structures.setdefault(
            known, [(one.name, str(one.kind), one.repeat, one.size) for one in definition.fields]
        )
    return assembled(short_name(name), parser.structures)


class _IdlParser:
    def __init__(self, tokens: list[str]) -> None:
        self.tokens = tokens
        self.at = 0
        self.structures: Definitions = {}
        self.aliases: dict[str, Type] = {}

    def next(self) -> str:
        if self.at >= len(self.tokens):
            raise ValueError("the text ends in the middle of a definition")
        self.at += 1
        return self.tokens[self.at - 1]

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def expect(self, token: str) -> None:
        next_token = self.next()
        if next_token != token:
            raise ValueError(f"found {next_token!r} where {token!r} is expected")

    def skip_to(self, last: str) -> None:
        while self.next() != last:
            pass

    def annotations(self) -> None:
        """Skip annotations such as `@key` and `@verbatim (language="comment", text="...")`."""
        while self.peek().startswith("@"):
            self.next()
            if self.peek() == "(":
                self.skip_to(")")

    def definitions(self, scope: tuple[str, ...]) -> None:
        while self.peek() not in ("", "}"):
            self.annotations()
            kind = self.next()
            if kind == "module":
                name = self.next()
                self.expect("{")
                if len(scope) > 8:
                    raise ValueError("modules are nested too deeply")
                self.definitions((*scope, name))
                self.expect("}")
            elif kind == "struct":
                name = self.next()
                self.expect("{")
                self.structures[short_name("/".join((*scope, name)))] = list(self.members(scope))
            elif kind == "enum":
                self.aliases["::".join((*scope, self.next()))] = ("uint32", "once", 0)
                self.skip_to("}")
            elif kind == "typedef":
                for name, alias in self.declared(scope):
                    self.aliases["::".join((*scope, name))] = alias
                continue
            elif kind == "const":
                self.skip_to(";")
                continue
            elif kind != ";":
                raise ValueError(f"{kind!r} is not a definition that ROS 2 writes")
            if self.peek() == ";":
                self.next()

    def members(self, scope: tuple[str, ...]) -> Iterator[tuple[str, str, Repeat, int]]:
        while True:
            self.annotations()
            if self.peek() == "}":
                self.next()
                return
            for name, (kind, repeat, size) in self.declared(scope):
                if name != "structure_needs_at_least_one_member":
                    yield name, kind, repeat, size

    def declared(self, scope: tuple[str, ...]) -> Iterator[tuple[str, Type]]:
        base = self.type(scope)
        while True:
            name, (kind, repeat, size) = self.next(), base
            if self.peek() == "[":
                if repeat != "once":
                    raise ValueError(f"{name!r} is an array of arrays")
                self.next()
                repeat = "fixed"
                size = self.number()
                self.expect("]")
            yield name, (kind, repeat, size)
            if (end := self.next()) != ",":
                break
        if end != ";":
            raise ValueError(f"found {end!r} where ';' is expected")

    def number(self) -> int:
        text = self.next()
        if not text.isascii() or not text.isdigit() or len(text) > 9:
            raise ValueError(f"found {text!r} where a number is expected")
        return int(text)

    def type(self, scope: tuple[str, ...]) -> Type:
        word = self.next()
        if word == "sequence":
            self.expect("<")
            kind, repeat, _ = self.type(scope)
            self.skip_to(">")
            if repeat != "once":
                raise ValueError("a sequence of arrays is not a type that ROS 2 writes")
            return kind, "sequence", 0
        while word in ("unsigned", "long", "unsigned long") and self.peek() in ("long", "short"):
            word = f"{word} {self.next()}"
        if word in TEXTS and self.peek() == "<":
            self.skip_to(">")
        if word in _BASIC:
            return _BASIC[word], "once", 0
        full = (word, "::".join((*scope, word)))
        return next(
            (self.aliases[name] for name in full if name in self.aliases),
            self.structure(word, scope),
        )

    @staticmethod
    def structure(word: str, scope: tuple[str, ...]) -> Type:
        return (
            short_name((word if "::" in word else "::".join((*scope, word))).replace("::", "/")),
            "once",
            0,
        )
