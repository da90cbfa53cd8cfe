"""YAML text to nodes: the same with and without libyaml, and bounded."""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents import yaml_parser
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.documentation_player import DATA

ROOT = Path(__file__).parents[2]
BENCH = (ROOT / "configs/clutch/bench.yaml").read_text()
PERIOD = "sample_period_s: 0.001"
REFUSED_VALUES = [
    "!!float abc",
    "!!int 0x1",
    '!!int ""',
    "!<x:float> abc",
    '"\\ud800"',
    "!!float 1_0",
    "!!float 0.001",
    "! 0.001",
    "!!str 0.001",
]


def _assess(tmp_path: Path, text: str) -> tuple[Path, float]:
    """Run `assess` on a bench of this text, which it must refuse; return the file and the seconds
    it took."""
    path = tmp_path / "bench.yaml"
    path.write_text(text)
    start = time.perf_counter()
    refused(run("assess", "--bench", path), 3, str(path))
    return path, time.perf_counter() - start


@pytest.mark.parametrize("fast", [True, False])
@pytest.mark.parametrize("value", REFUSED_VALUES)
def test_a_tag_or_half_a_character_is_refused_with_its_line(
    value: str, fast: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not fast:
        monkeypatch.setattr(yaml_parser, "fast_loader", yaml_parser._PlainLoader)
    path = tmp_path / "bench.yaml"
    path.write_text(BENCH.replace(PERIOD, f"sample_period_s: {value}"))
    line = next(
        number
        for number, text in enumerate(path.read_text().splitlines(), 1)
        if text.startswith("sample_period_s")
    )
    refused(
        run("assess", "--bench", path),
        3,
        f"{path}:{line}: found",
        "tag" if "!" in value else "surrogate",
    )


def test_the_values_of_the_attack_are_refused(tmp_path: Path) -> None:
    source = DATA / "attacks" / "yaml_tags.txt"
    if not source.exists():
        pytest.skip("FRICTOOL_DATA has no attacks/yaml_tags.txt")
    values = source.read_text().splitlines()[1:]
    assert len(values) >= 6
    for value in values:
        _assess(tmp_path, BENCH.replace(PERIOD, f"sample_period_s: {value}"))


@pytest.mark.parametrize(
    "text",
    [
        "".join(f"key_{index}: 1\n" for index in range(300_000)),
        f"name: {'x' * 40_000_000}\n",
        "{" + ",".join(f"a{index}" for index in range(290_000)) + "}",
        "a: [" + "1," * 990_000 + "1]\n",
        "? " + "x" * 1_900_000 + "\n: 1\n",
        "[" * 1_900_000,
        "- " * 900_000 + "1",
        "{a: " * 400_000,
        "a: &a [" + "1," * 1000 + "1]\nb: &b [" + "*a," * 1000 + "1]\nc: [" + "*b," * 1000 + "1]\n",
    ],
    ids=[
        "keys",
        "string",
        "flow keys",
        "list",
        "long key",
        "brackets",
        "dashes",
        "braces",
        "aliases",
    ],
)
def test_a_huge_document_is_refused_in_seconds(text: str, tmp_path: Path) -> None:
    _, seconds = _assess(tmp_path, text)
    assert seconds < 15.0


def _tree(node: yaml.Node | None) -> object:
    """Return the parts of a node that a reader uses: tag, line and content."""
    if isinstance(node, yaml.MappingNode):
        return (
            node.tag,
            node.start_mark.line,
            [(_tree(key), _tree(value)) for key, value in node.value],
        )
    if isinstance(node, yaml.SequenceNode):
        return node.tag, node.start_mark.line, [_tree(item) for item in node.value]
    assert isinstance(node, yaml.ScalarNode)
    return node.tag, node.start_mark.line, node.value


SHIPPED = sorted((ROOT / "configs").rglob("*.yaml"))


@pytest.mark.skipif(yaml_parser.CParser is None, reason="PyYAML was built without libyaml")
def test_libyaml_and_the_fallback_read_the_shipped_documents_alike() -> None:
    assert len(SHIPPED) > 30
    for path in SHIPPED:
        text = path.read_text()
        assert _tree(yaml_parser.compose(text)) == _tree(
            yaml_parser._composed(text, yaml_parser._PlainLoader)
        ), path


WORDS = ["1e-5", "no", "0x1", ".5", "~"]
SCALARS = st.one_of(
    st.text(max_size=12),
    st.floats(allow_nan=False),
    st.integers(),
    st.booleans(),
    st.none(),
    st.sampled_from(["1e-5", "no", "0x1", ".5", "~"]),
)
TREES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4)
    ),
    max_leaves=12,
)


@pytest.mark.skipif(yaml_parser.CParser is None, reason="PyYAML was built without libyaml")
@given(tree=TREES)
def test_libyaml_and_the_fallback_read_drawn_documents_alike(tree: object) -> None:
    text = yaml.safe_dump(tree, allow_unicode=False)
    if "!!" not in text:
        assert _tree(yaml_parser.compose(text)) == _tree(
            yaml_parser._composed(text, yaml_parser._PlainLoader)
        )


@given(text=st.text(alphabet="ab1.:-[]{}!&*'\"\\#?,|>% \n\t", max_size=40))
def test_no_text_raises_anything_else(text: str) -> None:
    for loader in (yaml_parser.fast_loader, yaml_parser._PlainLoader):
        with suppress(yaml.YAMLError, ValueError):
            yaml_parser._composed(text, loader)
