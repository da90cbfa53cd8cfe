"""Follow a recipe of CONTRIBUTING.md: its files and its changes are laid over the package.

`frictool` runs a command line in a process that imports the modules of a folder in place of those
of the package. The package itself stays as it is, and so do its compiled kernels.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path
from typing import Any, NamedTuple

from tests.support.documentation_pages import ROOT, text_of

STEP = re.compile(r"^\d+\. .*?(?=^\d+\. |\Z)", re.MULTILINE | re.DOTALL)
BLOCK = re.compile(r"^```(python|diff|yaml)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^frictool (.*)$", re.MULTILINE)
PATHS = {
    **dict.fromkeys(("python", "diff"), r"`(frictool/[\w/]+\.py)`"),
    "yaml": r"`(\w+\.yaml)`",
}


def recipes() -> dict[str, str]:
    """Return the text of each recipe by its heading."""
    section = text_of(ROOT / "CONTRIBUTING.md").split("## Recipes\n")[1]
    return dict(part.split("\n", 1) for part in re.split(r"^### ", section, flags=re.M)[1:])


def blocks(heading: str) -> Iterator[tuple[str, str, str]]:
    """Yield the file, the language and the text of each block in the steps of a recipe.

    A block of a step belongs to the first path of its kind in the step's text.
    """
    for step in STEP.findall(recipes()[heading]):
        for language, text in BLOCK.findall(step):
            yield re.findall(PATHS[language], step)[0], language, text


def follow(heading: str, overlay: Path) -> None:
    """Write the files that the recipe under `heading` makes and changes to `overlay`."""
    for name, language, text in blocks(heading):
        target = overlay / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if language == "diff":
            text = changed((ROOT / name).read_text(encoding="utf-8"), text)
        target.write_text(text, encoding="utf-8")


def changed(text: str, difference: str) -> str:
    """Return the text with each hunk applied; its lines must occur exactly once."""
    for hunk in difference.split("@@\n"):
        lines = hunk.splitlines(keepends=True)
        before, after = ("".join(line[1:] for line in lines if line[0] != sign) for sign in "+-")
        assert text.count(before) == 1, f"not once in the file:\n{before}"
        text = text.replace(before, after)
    return text


class Ended(NamedTuple):
    """Exit code and texts of a command."""

    returncode: int
    stdout: str
    stderr: str


def frictool(overlay: Path, *arguments: str | Path) -> Ended:
    """Run `frictool ARGUMENTS` in the folder `overlay`, with the modules in it."""
    (ended,) = frictool_each(overlay, arguments)
    return ended


def frictool_each(overlay: Path, *lines: Sequence[str | Path]) -> list[Ended]:
    """Run command lines one after the other in one process, as `frictool` runs one."""
    words = json.dumps([[*map(str, line)] for line in lines])
    done = subprocess.run(
        [sys.executable, "-m", __name__, str(overlay), words],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        cwd=overlay,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [Ended(*one) for one in json.loads(done.stdout)]


class Overlay:
    """Finder of modules whose files are in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        file = self._folder.joinpath(*name.split(".")).with_suffix(".py")
        return spec_from_file_location(name, file) if file.is_file() else None


if __name__ == "__main__":
    sys.meta_path.insert(0, Overlay(Path(sys.argv[1])))
    from studies.command_line import run

    ended = [run(*line) for line in json.loads(sys.argv[2])]
    print(json.dumps([(one.code, one.stdout, one.stderr) for one in ended]))
