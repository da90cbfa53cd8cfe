"""Several files into a folder: all or none, nobody else's, the same archive every time."""

from __future__ import annotations

import io
import tarfile
from pathlib import Path

import pytest

from frictool.cli.output_folder import archive, save_folder
from frictool.errors import OutputError
from studies.command_line import run
from tests.support.command_line import refused

ROOT = Path(__file__).parents[2]
FILES = {"a.txt": "α\n", "deep/b.txt": "b\n"}


def names(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_a_new_folder_appears_whole_and_leaves_nothing_beside_it(tmp_path: Path) -> None:
    (tmp_path / "x").mkdir()
    save_folder(tmp_path / "x/new", FILES, [], overwrite=False)
    assert names(tmp_path) == ["x", "x/new", "x/new/a.txt", "x/new/deep", "x/new/deep/b.txt"]
    assert (tmp_path / "x/new/a.txt").read_bytes() == "α\n".encode()
    assert (tmp_path / "x/new").stat().st_mode & 0o777 == (tmp_path / "x").stat().st_mode & 0o777


def test_an_old_folder_keeps_what_it_has(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / "a.txt").write_text("old")
    with pytest.raises(OutputError, match=r"already contains a\.txt"):
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
        assert [(entry.name, entry.mtime, entry.uid, entry.mode) for entry in tar] == [
            ("a.txt", 0, 0, 0o644),
            ("deep/b.txt", 0, 0, 0o644),
        ]


MISSING = [
    ("ingest {sines} --bench {bench} -o {out}/run.mcap", "run.mcap"),
    ("assess --bench {bench} -o {out}/assess.txt", "assess.txt"),
    ("excite --bench {bench} --kind sines -o {out}/test.csv", "test.csv"),
    ("identify {sines} --bench {bench} -o {out}/model.yaml", "model.yaml"),
    ("identify --each log {sines} --bench {bench} -o {out}/models", "models"),
    ("schema bench -o {out}/bench.json", "bench.json"),
    ("convert {sines} --bench {bench} -o {out}/log.csv", "log.csv"),
    ("compare -o {out}/laws", "laws"),
    ("compare -o {out}/laws.html", "laws.html"),
]


@pytest.mark.parametrize(("line", "target"), MISSING, ids=lambda item: item.split()[0])
def test_a_missing_folder_is_named_and_not_made(line: str, target: str, tmp_path: Path) -> None:
    """A misspelt folder must not become one."""
    given = {
        "sines": ROOT / "sample_logs/sines.csv",
        "bench": ROOT / "configs/clutch/bench.yaml",
        "out": tmp_path / "bulid" / "logs",
    }
    words = line.format(**given).split()
    result = run(*words)
    refused(
        result,
        3,
        f"{given['out'] / target}: there is no folder {given['out']}",
        f"mkdir -p {given['out']}",
    )
    assert list(tmp_path.iterdir()) == []
