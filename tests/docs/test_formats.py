"""The YAML of docs/formats.md and docs/log_formats.md is read: whole documents as they stand, parts
of documents put into a working one."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from frictool.documents.registry import DOCUMENTS, load
from tests.support.documentation_pages import ROOT, Block, blocks


class Loader(yaml.SafeLoader):
    """Takes the key `on` for a word, as frictool does, and not for a truth value."""


Loader.yaml_implicit_resolvers = {
    letter: rules
    for letter, rules in yaml.SafeLoader.yaml_implicit_resolvers.items()
    if letter != "o"
}

CLUTCH = ROOT / "configs" / "clutch"
BLOCKS = [
    block
    for name in ("formats.md", "log_formats.md")
    for block in blocks(ROOT / "docs" / name, "yaml")
]

# what a block begins with -> the document that it is a part of, and what of that document makes
# room for it
PARTS: dict[str, tuple[str, Path, tuple[str, ...]]] = {
    "load": ("bench", CLUTCH / "bench.yaml", ()),
    "columns": ("bench", CLUTCH / "bench.yaml", ("columns",)),
    "reference": ("scenario", CLUTCH / "scenarios/steps.yaml", ("steps",)),
    "variants": ("scenario", CLUTCH / "scenarios/steps.yaml", ("variants",)),
    "spread": ("scenario", CLUTCH / "scenarios/steps.yaml", ()),
    "duration_s": ("scenario", ROOT / "configs/screw/push.yaml", ("sources",)),
}
# `...` stands for what is left out in these; tests/documents reads golden documents that have every
# key
SHORTENED = ("presliding", "switched")
WHOLE = [block for block in BLOCKS if "\nname: " in block.text]
PARTIAL = [
    block
    for block in BLOCKS
    if "format: " not in block.text and not block.text.startswith(SHORTENED)
]


@pytest.mark.parametrize("block", WHOLE, ids=lambda block: f"line {block.line}")
def test_a_whole_document_is_read(block: Block, tmp_path: Path) -> None:
    name = yaml.safe_load(block.text)["format"].partition("/")[0]
    path = tmp_path / f"{name}.yaml"
    path.write_text(block.text)
    load(path, DOCUMENTS[name])


@pytest.mark.parametrize("block", PARTIAL, ids=lambda block: f"line {block.line}")
def test_a_part_of_a_document_is_read_within_one(block: Block, tmp_path: Path) -> None:
    told = yaml.load(block.text, Loader)
    first = next(iter(told))
    name, base, room = PARTS[first]
    document = {
        key: value for key, value in yaml.load(base.read_text(), Loader).items() if key not in room
    }
    for key, value in told.items():
        document[key] = (
            {**document[key], **value}
            if isinstance(value, dict) and isinstance(document.get(key), dict)
            else value
        )
    path = tmp_path / f"{name}.yaml"
    path.write_text(yaml.safe_dump(document, sort_keys=False))
    load(path, DOCUMENTS[name])
