"""Kept trials: whole after any kill, of one campaign, written by one."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.campaign.trials.differential_evolution import SearchResult
from frictool.campaign.trials.trial_store import TrialStore
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, TrialResult
from frictool.cli import campaign_inputs
from frictool.errors import InputFileError, OutputError

HEADER = {"frictool": "1", "method": "random", "seed": 4, "model": "a" * 64}
TRIALS = [
    TrialResult(0, (0.1 + 0.2, math.nan, math.inf), (MET, UNDECIDED, BROKEN)),
    TrialResult(7, (), (), "v: a plant of “glass”\nbroke"),
    TrialResult(3, (-math.inf, 1e-300, 5.0), (BROKEN, MET, MET)),
]
ASKED = ("overshoot", 300, 1000)
WORST = SearchResult("overshoot", math.inf, 4.5, (0.0, 0.1 + 0.7, 1.0), 12, 300, 2)


@pytest.fixture(name="path")
def _path(tmp_path: Path) -> Path:
    path = tmp_path / "trials.jsonl"
    with TrialStore(path, HEADER) as store:
        store.add(TRIALS[:2])
        store.add_worst(ASKED, WORST)
        store.add(TRIALS[2:])
    return path


def test_what_was_added_is_there_again(path: Path) -> None:
    with TrialStore(path, HEADER) as store:
        in_order = sorted(TRIALS, key=lambda trial: trial.draw)
        assert repr(list(store.trials.values())) == repr(in_order)  # nan is not nan
        assert store.worst == {ASKED: WORST}


@given(st.data())
def test_a_kill_at_any_byte_loses_the_line_that_was_written_at_most(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = tmp_path_factory.getbasetemp() / "killed.jsonl"
    path.unlink(missing_ok=True)
    with TrialStore(path, HEADER) as store:
        store.add(TRIALS)
    whole = path.read_bytes()
    cut = data.draw(st.integers(0, len(whole)))
    path.write_bytes(whole[:cut])
    with TrialStore(path, HEADER) as store:
        assert len(store.trials) == max(0, whole[:cut].count(b"\n") - 1)
        store.add([trial for trial in TRIALS if trial.draw not in store.trials])
    assert path.read_bytes() == whole


def test_another_campaign_s_file_is_refused_by_what_differs(path: Path) -> None:
    with pytest.raises(
        InputFileError, match="another campaign, whose seed is different: found 4, here 5"
    ):
        TrialStore(path, HEADER | {"seed": 5})
    with pytest.raises(InputFileError, match="whose model is different; name another file"):
        TrialStore(path, HEADER | {"model": "b" * 64})


def test_trials_kept_before_a_change_of_a_metric_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package, kept = tmp_path / "frictool", tmp_path / "kept.jsonl"
    for part in ("documents", "metrics", "report"):
        shutil.copytree(campaign_inputs.PACKAGE / part, package / part)
    monkeypatch.setattr(campaign_inputs, "PACKAGE", package)
    trial: Any = SimpleNamespace(seed=4, setting=SimpleNamespace(number="double"))
    paths: Any = SimpleNamespace(inputs={})
    for _ in range(2):
        TrialStore(kept, campaign_inputs.header_of(trial, paths, "random", None)).close()
    metric = package / "metrics/overshoot.py"
    metric.write_text(metric.read_text(encoding="utf-8").replace("100.0", "200.0"))
    with pytest.raises(
        InputFileError, match="another campaign, whose code of the metrics is different"
    ):
        TrialStore(kept, campaign_inputs.header_of(trial, paths, "random", None))


def test_a_campaign_that_ends_before_its_first_trial_leaves_no_file(
    tmp_path: Path, path: Path
) -> None:
    kept = path.read_bytes()
    for file in (tmp_path / "new.jsonl", path):
        with pytest.raises(RuntimeError), TrialStore(file, HEADER):
            raise RuntimeError
    assert not (tmp_path / "new.jsonl").exists()
    assert path.read_bytes() == kept


def test_what_is_no_such_file_is_refused_and_stays_as_it_was(tmp_path: Path) -> None:
    for content in (
        b"draw,passed\n0,met\n",
        b"[]\n",
        b'{"format":"campaign-trials/1"',
        b"\x00\xff\n",
        b"x",
    ):
        path = tmp_path / "other.csv"
        path.write_bytes(content)
        if content.startswith(b'{"format"'):  # a header that a kill has cut off
            TrialStore(path, HEADER).close()
            continue
        with pytest.raises(InputFileError):
            TrialStore(path, HEADER)
        assert path.read_bytes() == content


def test_damage_in_the_middle_is_told_by_its_line(path: Path) -> None:
    lines = path.read_text().split("\n")
    for damaged in ("[1, 0]x", "[1]", "{}", '["a", 1, [], []]', "null"):
        path.write_text("\n".join([lines[0], lines[1], damaged, *lines[2:]]))
        with pytest.raises(InputFileError, match=r"trials.jsonl:3: is not a line of stored trials"):
            TrialStore(path, HEADER)


def test_one_campaign_at_a_time_writes_it(path: Path) -> None:
    with (
        TrialStore(path, HEADER),
        pytest.raises(OutputError, match="another campaign is writing to this file"),
    ):
        TrialStore(path, HEADER)
    TrialStore(path, HEADER).remove()
    assert not path.exists()


def test_without_a_file_nothing_is_kept(tmp_path: Path) -> None:
    with TrialStore(None, HEADER) as store:
        store.add(TRIALS)
        assert set(store.trials) == {0, 3, 7}
        store.remove()


def test_a_folder_and_a_place_that_cannot_be_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match="is a directory"):
        TrialStore(tmp_path, HEADER)
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        TrialStore(tmp_path / "file" / "below", HEADER)
