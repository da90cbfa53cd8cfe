"""Parser of YAML text into nodes, bounded in depth and number of nodes.

If PyYAML was built with libyaml, the parser uses libyaml, which is about five times faster.
PyYAML's composer in C is not used, because a deeply nested text crashes this composer.
"""

from __future__ import annotations

from typing import Any

import yaml
from yaml.composer import Composer, ComposerError
from yaml.resolver import BaseResolver

from frictool.documents.yaml_scalars import Loader

try:
    from yaml._yaml import CParser
except ImportError:  # PyYAML built without libyaml
    CParser = None  # type: ignore[assignment, misc]  # the parser in Python replaces it

MAX_DEPTH = 100
MAX_NODES = 200_000  # reading this number takes some seconds; an alias counts at each use
# characters; a shorter text that libyaml refuses is parsed again by PyYAML, which names the line
RETRY_CHARACTERS = 50_000
YAML_TAGS = "tag:yaml.org,2002:"


class RefusedYaml(ComposerError):
    """Error for valid YAML that uses a feature that documents must not use."""


class _BoundedComposer(Composer):
    def compose_document(self) -> yaml.Node | None:
        self._depth = 0
        self._nodes = 0
        self._sizes: dict[str, int] = {}  # anchor -> number of nodes
        node: yaml.Node | None = super().compose_document()
        return node

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        event: Any = self.peek_event()  # type: ignore[attr-defined]  # a method of the parser, with which this class is combined
        before = self._nodes
        if isinstance(event, yaml.AliasEvent):
            self._count(self._sizes.get(str(event.anchor), 0), event)
        else:
            if event.tag is not None:
                raise _refusal(
                    f"found the tag {_as_written(event.tag)}; write the value without a tag", event
                )
            self._count(1, event)
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise _refusal(f"nested too deeply; allowed: at most {MAX_DEPTH} levels", event)
        node: yaml.Node | None = super().compose_node(parent, index)
        self._depth -= 1
        if event.anchor is not None and not isinstance(event, yaml.AliasEvent):
            self._sizes[event.anchor] = self._nodes - before
        if isinstance(node, yaml.ScalarNode) and not node.value.isascii():
            try:
                node.value.encode()
            except UnicodeEncodeError:
                raise _refusal(
                    "found half of a surrogate pair, which is not a character", event
                ) from None
        return node

    def _count(self, nodes: int, event: yaml.Event) -> None:
        self._nodes += nodes
        if self._nodes > MAX_NODES:
            raise _refusal(f"has more than {MAX_NODES} values; allowed: at most this number", event)


class _PlainLoader(_BoundedComposer, Loader):
    """Loader with PyYAML's own parser."""


def _fast_loader() -> type[Any]:
    if CParser is None:
        return _PlainLoader

    class FastLoader(_BoundedComposer, CParser, BaseResolver):
        yaml_implicit_resolvers = Loader.yaml_implicit_resolvers

        def __init__(self, text: str) -> None:
            CParser.__init__(self, text)
            Composer.__init__(self)
            BaseResolver.__init__(self)

    return FastLoader


fast_loader = _fast_loader()


def compose(text: str) -> yaml.Node | None:
    """Parse the text of a document and return the root node; None if the text is empty.

    Raises RefusedYaml if the document has a tag or exceeds a bound. Raises another yaml.YAMLError
    or ValueError if the text is not YAML.
    """
    try:
        return _composed(text, fast_loader)
    except yaml.YAMLError:
        if len(text) < RETRY_CHARACTERS and fast_loader is not _PlainLoader:
            _composed(text, _PlainLoader)  # its messages are the same on every machine
        raise


def _composed(text: str, loader_class: type[Any]) -> yaml.Node | None:
    loader = loader_class(text)
    try:
        node: yaml.Node | None = loader.get_single_node()
    finally:
        loader.dispose()
    return node


def _refusal(problem: str, event: yaml.Event) -> RefusedYaml:
    return RefusedYaml(None, None, problem, event.start_mark)  # type: ignore[arg-type]  # libyaml's mark has the same fields


def _as_written(tag: str) -> str:
    written = (
        f"!!{tag.removeprefix(YAML_TAGS)}"
        if tag.startswith(YAML_TAGS)
        else tag
        if tag.startswith("!")
        else f"!<{tag}>"
    )
    return written if len(written) <= 40 else f"{written[:37]}..."
