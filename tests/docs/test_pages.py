"""Every command of every page runs as it stands there and prints what the page says; links lead
somewhere; files, checks and options exist.

Each page is played in a copy of its own after the README's commands: it uses what they leave in
`build/`.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest
import yaml

from benchmarks import __main__ as bench
from tests.accept import __main__ as accept
from tests.support.documentation_pages import (
    PAGES,
    ROOT,
    Block,
    anchors,
    blocks,
    links,
    name_of,
    prose,
    text_of,
)
from tests.support.documentation_player import agrees, first_missing, play, scratch

README = ROOT / "README.md"
ELSEWHERE = {  # pages with a test of their own, in a folder of their own
    "docs/tutorial.md": "tests/docs/test_tutorial.py",
    "docs/tutorial_emps.md": "tests/docs/test_tutorial_emps.py",
    "docs/theory/mechanism.md": "tests/mechanism/test_page.py",
    "CONTRIBUTING.md": "tests/support/recipes.py",
}
# the folders of tests of these commands run them too, on smaller examples
LONG = (
    "docs/limits.md",
    "docs/tutorial_plan.md",
    "docs/weights.md",
    *(
        f"docs/theory/{name}.md"
        for name in (
            *("campaign", "compare", "excite", "export", "export_models", "observers", "reduce"),
            *("identify", "identify_effects", "identify_many", "report", "simulate", "synth"),
            "velocity",
        )
    ),
)
PLAYED = [
    pytest.param(page, marks=pytest.mark.accept) if name_of(page) in LONG else page
    for page in PAGES
    if blocks(page, "sh", "python") and page != README and name_of(page) not in ELSEWHERE
]
LANGUAGES = {"sh", "text", "python", "console", "yaml", "c", "matlab", "json", "diff"}
TARGETS = re.compile(r"make(?: -C (\S+))?(?: (\w[\w =-]*))?$")


@pytest.fixture(scope="module")
def readme(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The copy, after the commands of the README."""
    folder = scratch(tmp_path_factory.mktemp("docs"))
    with pytest.MonkeyPatch.context() as patch:
        play(README, folder, patch)
    return folder


def test_the_readme_s_commands_end_with_a_page(readme: Path) -> None:
    assert (readme / "build/report.html").read_text().startswith("<!DOCTYPE html>")


@pytest.mark.parametrize("page", PLAYED, ids=name_of)
def test_the_commands_of_a_page_print_what_it_says(
    page: Path, readme: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = Path(shutil.copytree(readme, tmp_path / "clone"))
    play(page, copy, monkeypatch)
    shutil.rmtree(copy)  # 25 MB, which pytest would keep


@pytest.mark.parametrize(("page", "test"), ELSEWHERE.items())
def test_other_pages_have_a_test_of_their_own(page: str, test: str) -> None:
    assert Path(page).name in (ROOT / test).read_text()


def test_the_readme_opens_with_the_two_commands() -> None:
    opening = text_of(README).splitlines()[:6]
    assert any(line.strip().startswith("make demo") for line in opening)
    assert any(line.strip().startswith("make test") for line in opening)


def test_every_command_is_in_the_readme_s_table() -> None:
    from frictool.cli.main import COMMANDS as registered

    assert set(re.findall(r"^\| `(\w+)", text_of(README), re.MULTILINE)) == set(registered)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_link_leads_somewhere(page: Path) -> None:
    for path, anchor in links(page):
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{name_of(page)} links to {path}"
        assert not anchor or anchor in anchors(target), (
            f"{name_of(page)} links to {path}#{anchor}; there are {sorted(anchors(target))}"
        )


def test_every_page_is_reached_from_the_readme() -> None:
    reached, new = set(), {README}
    while new:
        reached |= new
        new = {
            (page.parent / path).resolve()
            for page in new
            for path, _ in links(page)
            if path.endswith(".md")
        } - reached
    assert {name_of(page) for page in PAGES if page not in reached} == set()


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_a_block_says_what_it_is(page: Path) -> None:
    for block in blocks(page):
        assert block.language in LANGUAGES, (
            f"{name_of(page)}, line {block.line}: {block.language!r}"
        )
        if block.language == "yaml":
            yaml.safe_load(block.text)
    indented = re.findall(r"^ {4}(?:frictool|make|python|cc) .*", prose(page), re.MULTILINE)
    assert page == README or not indented, (
        f"{name_of(page)}: a command that no test runs: {indented}"
    )


def _console(page: Path) -> list[tuple[str, Block]]:
    return [(line, block) for block in blocks(page, "console") for line in block.lines]


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "console")], ids=name_of)
def test_what_takes_too_long_here_says_so_and_can_be_made(page: Path) -> None:
    """`make accept` runs these lines: tests/accept/check_docs.py."""
    for line, block in _console(page):
        command, _, reason = line.partition("  #")
        assert reason.strip(), (
            f"{name_of(page)}, line {block.line}: why is {line!r} not run with the others?"
        )
        _can_be_made(page, command.strip())


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_targets_named_in_the_text_can_be_made(page: Path) -> None:
    for command in sorted(set(re.findall(r"`(make [^`]*)`", prose(page)))):
        _can_be_made(page, command)


@cache
def _can_be_made(page: Path, command: str) -> None:
    target = TARGETS.match(command)
    assert target, f"{name_of(page)}: {command!r}"
    made = subprocess.run(
        ["make", "-n", "-C", target[1] or ".", *(target[2] or "").split()],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert made.returncode == 0, f"{command}\n{made.stderr}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_named_checks_and_rows_exist(page: Path) -> None:
    text = text_of(page).replace("\n", " ")
    for checks in re.findall(
        r"python -m tests\.accept [^\s`]+((?: (?:\"[^\"]+\"|'[^']+'|[a-z]\w+))+)", text
    ):
        named = [
            name
            for group in re.findall(r"\"([^\"]+)\"|'([^']+)'|([a-z]\w+)", checks)
            for name in group
            if name
        ]
        unknown = [name for name in named if name not in _checks() | {"NAME"}]
        assert not unknown, f"{name_of(page)}: no check is called {unknown}"
    for rows in re.findall(r"python -m benchmarks [^\s`]+((?: [a-z]\w*\.[\w.]+)+)", text):
        unknown = [name for name in rows.split() if name not in _rows()]
        assert not unknown, f"{name_of(page)}: no row is called {unknown}"


def _checks() -> set[str]:
    return set(accept.collect(Path(accept.__file__).parent))


def _rows() -> set[str]:
    return {bench.name_of(row) for row in bench.collect(Path(bench.__file__).parent)}


def test_a_line_that_has_changed_is_noticed() -> None:
    assert agrees("inertia  1.3201e-05 kg", "inertia 1.32e-05 kg")
    assert not agrees("inertia  1.3301e-05 kg", "inertia 1.3201e-05 kg")
    assert agrees("offset  -3.3652 [-6, 0.58445]", "offset -3.3652 [-6, 0.58443]", units=10)
    assert not agrees("offset  -3.3652 [-6, 0.58445]", "offset -3.3652 [-6, 0.58443]")
    assert not agrees("mass 1.3201e-05 kg", "inertia 1.3201e-05 kg")
    assert agrees("margin 0.648 at v02", "margin 0.621 at v14", solved=True)
    assert not agrees("margin 0.821 at v02", "margin 0.621 at v02", solved=True)
    assert agrees(
        "margin > 0.615 (33 cells, exact)", "margin > 0.616 (13 cells, exact)", solved=True
    )
    assert not agrees("margin > 0.616 (33 cells, exact)", "margin > 0.616 (13 cells, exact)")
    assert not agrees(
        "stable at all 16 vertices, margin 0.49 >= 0.5",
        "stable at all 16 vertices, margin 0.52 >= 0.5",
        solved=True,
    )
    assert not agrees("order 5", "order 4", solved=True)
    assert not agrees("response 0.21 <= 0.22", "response 0.23 <= 0.22", solved=True)
    judged = "MET static error 0.6242 rad   <= 2 rad   run.mcap /axis/v03, step 2 at 1.1 s"
    assert agrees(
        "MET static error 0.4 rad   <= 2 rad   run.mcap /axis/v15, step 1 at 0 s",
        judged,
        solved=True,
    )
    assert not agrees(
        "MET static error 1.4 rad   <= 2 rad   run.mcap /axis/v15, step 1 at 0 s",
        judged,
        solved=True,
    )
    assert not agrees(
        "MET static error 0.6 rad   <= 3 rad   run.mcap /axis/v15, step 1 at 0 s",
        judged,
        solved=True,
    )
    assert not agrees(
        "MET static error 0.4 rad   <= 2 rad   run.mcap /axis/v15, step 1 at 0 s", judged
    )
    printed = ["a 1", "", "b 2", "c 3", "d 4"]
    assert first_missing(printed, ["a 1", "...", "c 3", "d 4"]) is None
    assert first_missing(printed, ["...", "b 2", "..."]) is None
    assert first_missing(printed, ["a 1", "b 2", "c 3", "d 4"]) is None
    assert (
        first_missing(printed, ["a 1", "c 3", "..."]) is not None
    )  # a line is left out without a word
    assert first_missing(printed, ["b 2", "..."]) is not None
    assert first_missing(printed, ["a 1", "..", "e 5"]) is not None
    assert first_missing(printed, ["a 1", "b 2"]) is not None  # the end is left out without a word
    assert first_missing(printed, ["...", "c 3", "...", "b 2", "..."]) is not None
