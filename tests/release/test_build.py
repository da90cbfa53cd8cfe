"""Source distribution and wheel: the same bytes wherever they are built, and all that belongs in
them. `make dist` builds this tree so."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from release.__main__ import ROOT, TWICE
from release.build import Failed, build, normalised
from release.contents import check
from release.source import MADE, epoch_of, source

setuptools = pytest.importorskip("setuptools", minversion="77.0.3")
EPOCH = 1_700_000_000


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small package built as this one is: the whole one takes ten seconds."""
    folder = tmp_path_factory.mktemp("tree") / "tree"
    for name in (
        "pyproject.toml",
        "MANIFEST.in",
        "README.md",
        "docs/package.md",
        "LICENSE",
        "frictool/__init__.py",
        "frictool/py.typed",
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes((ROOT / name).read_bytes())
    (folder / "frictool/report").mkdir()
    for name in ("__init__.py", "page.html.jinja"):
        (folder / "frictool/report" / name).write_bytes(
            (ROOT / "frictool/report" / name).read_bytes()
        )
    return folder


@pytest.fixture(scope="module")
def made(tree: Path, tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Path, Path]]:
    """(source distribution, wheel), built twice."""
    place = tmp_path_factory.mktemp("made")
    return [
        build(source(tree, place / name / "tree"), place / name / "out", EPOCH, one)
        for name, one in zip("ab", TWICE, strict=True)
    ]


def test_two_builds_in_other_surroundings_have_the_same_bytes(
    tree: Path, made: list[tuple[Path, Path]]
) -> None:
    for one, other in zip(*made, strict=True):
        assert one.read_bytes() == other.read_bytes()
    check(tree, *made[0])
    with zipfile.ZipFile(made[0][1]) as wheel:
        assert (
            "frictool = frictool.cli.main:main"
            in wheel.read("frictool-0.1.0.dist-info/entry_points.txt").decode()
        )
        assert (
            "License-Expression: Apache-2.0"
            in wheel.read("frictool-0.1.0.dist-info/METADATA").decode()
        )
    with tarfile.open(made[0][0]) as tar:
        assert {(member.mtime, member.uname, member.uid) for member in tar.getmembers()} == {
            (EPOCH, "", 0)
        }


def test_every_file_of_the_package_is_asked_for() -> None:
    """A file that package-data leaves out is missing in a wheel, and in no clone."""
    import tomllib
    from fnmatch import fnmatch

    asked = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"][
        "package-data"
    ]["frictool"]
    others = [
        path.relative_to(ROOT / "frictool")
        for path in (ROOT / "frictool").rglob("*")
        if path.is_file() and path.suffix != ".py"
    ]
    kept = [path for path in others if "__pycache__" not in path.parts]
    assert kept
    for path in kept:
        assert any(
            fnmatch(path.as_posix(), pattern) or fnmatch(path.name, pattern.removeprefix("**/"))
            for pattern in asked
        ), path
    for folder in {
        path.parent for path in (ROOT / "frictool").rglob("*.py") if "__pycache__" not in path.parts
    }:
        assert (folder / "__init__.py").is_file(), (
            f"{folder} is no package, and its modules would not be packed"
        )


def test_every_folder_of_the_clone_is_asked_for() -> None:
    asked = (ROOT / "MANIFEST.in").read_text().split()
    made = {"build", "dist", ".venv", ".git"}
    for path in ROOT.iterdir():
        if (
            path.is_dir()
            and path.name not in made
            and not path.name.endswith((".egg-info", "_cache"))
            and path.name != "__pycache__"
        ):
            assert path.name in asked or path.name.startswith(".hypothesis"), (
                f"{path.name} would not be in the source distribution"
            )


def test_what_is_missing_or_unwanted_is_named(
    tree: Path, made: list[tuple[Path, Path]], tmp_path: Path
) -> None:
    sdist, wheel = made[0][0], tmp_path / made[0][1].name
    wheel.write_bytes(made[0][1].read_bytes())
    (tree / "frictool" / "new.txt").write_text("not packed")
    try:
        with pytest.raises(Failed, match=r"lacks frictool/new\.txt"):
            check(tree, sdist, wheel)
    finally:
        (tree / "frictool" / "new.txt").unlink()
    with zipfile.ZipFile(wheel, "a") as archive:
        archive.writestr("frictool/__pycache__/kernel.nbc", b"")
    with pytest.raises(Failed, match=r"beside the package, frictool/__pycache__/kernel\.nbc"):
        check(tree, sdist, wheel)


def test_an_archive_is_sorted_and_knows_no_one(tmp_path: Path) -> None:
    with tarfile.open(tmp_path / "old.tar.gz", "w:gz") as tar:
        for name, mode in (("b", 0o600), ("a", 0o700)):
            member = tarfile.TarInfo(name)
            member.size, member.mode, member.uname, member.mtime = 1, mode, "somebody", 5.5
            tar.addfile(member, io.BytesIO(b"x"))
    with tarfile.open(normalised(tmp_path / "old.tar.gz", tmp_path / "new.tar.gz", EPOCH)) as tar:
        found = [(member.name, member.mode, member.uname, member.mtime) for member in tar]
    assert found == [("a", 0o755, "", EPOCH), ("b", 0o644, "", EPOCH)]


def test_the_date_is_the_commit_s_or_what_the_environment_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1234567890")
    assert epoch_of(tmp_path) == 1234567890
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    (tmp_path / "PKG-INFO").write_text("")
    os.utime(tmp_path / "PKG-INFO", (EPOCH, EPOCH))
    assert epoch_of(tmp_path) == EPOCH
    git = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b"]
    when = {"GIT_COMMITTER_DATE": "2026-01-02T03:04:05Z", "GIT_AUTHOR_DATE": "2026-01-02T03:04:05Z"}
    for words in (["init", "-q"], ["add", "PKG-INFO"], ["commit", "-qm", "first"]):
        subprocess.run([*git, *words], check=True, env=os.environ | when, capture_output=True)
    assert epoch_of(tmp_path) == 1767323045
    (tmp_path / "later").write_text("not committed")
    assert sorted(path.name for path in source(tmp_path, tmp_path / "copy").iterdir()) == [
        "PKG-INFO"
    ]


def test_a_build_that_fails_says_why(tree: Path, tmp_path: Path) -> None:
    broken = source(tree, tmp_path / "tree")
    (broken / "frictool" / "__init__.py").write_text('__version__ = "no version"\n')
    with pytest.raises(Failed, match="build_sdist: "):
        build(broken, tmp_path / "out", EPOCH, TWICE[0])


def test_what_is_made_is_not_copied(tmp_path: Path) -> None:
    for name in ("frictool", "build", "frictool/__pycache__", ".venv", "frictool.egg-info"):
        (tmp_path / "root" / name).mkdir(parents=True)
    copy = source(tmp_path / "root", tmp_path / "copy")
    assert [path.relative_to(copy).as_posix() for path in copy.rglob("*")] == ["frictool"]
    assert "__pycache__" in MADE
    assert sys.version_info >= (3, 11)
