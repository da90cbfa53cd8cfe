"""Several files into a folder: all or none, nobody else's, the same archive every time."""

from __future__ import annotations

import io
import tarfile
from pathlib import Path

import pytest

from frictool.cli.folder import archive, save_folder
from frictool.errors import OutputError

FILES = {"a.txt": "α\n", "deep/b.txt": "b\n"}


def names(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_a_new_folder_appears_whole_and_leaves_nothing_beside_it(tmp_path: Path) -> None:
    save_folder(tmp_path / "x/new", FILES, [], overwrite=False)
    assert names(tmp_path) == ["x", "x/new", "x/new/a.txt", "x/new/deep", "x/new/deep/b.txt"]
    assert (tmp_path / "x/new/a.txt").read_bytes() == "α\n".encode()
    assert (tmp_path / "x/new").stat().st_mode & 0o777 == (tmp_path / "x").stat().st_mode & 0o777


def test_an_old_folder_keeps_what_it_has(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / "a.txt").write_text("old")
    with pytest.raises(OutputError, match=r"already holds a\.txt"):
        save_folder(tmp_path, FILES, [], overwrite=False)
    assert names(tmp_path) == ["a.txt", "mine.txt"]
    save_folder(tmp_path, FILES, [], overwrite=True)
    assert names(tmp_path) == ["a.txt", "deep", "deep/b.txt", "mine.txt"]
    assert (tmp_path / "mine.txt").read_text() == "mine"
    assert (tmp_path / "a.txt").read_text() == "α\n"


def test_a_failure_halfway_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out/a.txt").write_text("old")
    whole = Path.write_bytes

    def full_disk(path: Path, data: bytes) -> int:
        if path.name == "b.txt":
            raise OSError(28, "No space left on device")
        return whole(path, data)

    monkeypatch.setattr(Path, "write_bytes", full_disk)
    with pytest.raises(OutputError, match="No space left on device"):
        save_folder(tmp_path / "out", FILES, [], overwrite=True)
    assert names(tmp_path) == ["out", "out/a.txt"]
    assert (tmp_path / "out/a.txt").read_text() == "old"


@pytest.mark.parametrize("target", ["file", "file/below", "link"])
def test_a_file_in_the_way_is_an_error(target: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("a file")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    with pytest.raises(OutputError, match=target):
        save_folder(tmp_path / target, FILES, [], overwrite=True)
    assert names(tmp_path) == ["file", "link"]


def test_an_input_is_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("input")
    with pytest.raises(OutputError, match="is an input"):
        save_folder(tmp_path, FILES, [tmp_path / "a.txt"], overwrite=True)
    assert (tmp_path / "a.txt").read_text() == "input"


def test_archive_is_a_function_of_the_files() -> None:
    assert archive(FILES) == archive(dict(FILES))
    with tarfile.open(fileobj=io.BytesIO(archive(FILES))) as tar:
        assert [(entry.name, entry.mtime, entry.uid, entry.mode) for entry in tar] == [("a.txt", 0, 0, 0o644), ("deep/b.txt", 0, 0, 0o644)]
