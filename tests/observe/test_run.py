"""`observe run` along one log: what it finds, when it knew it, its interval, its verdict; outputs
whole or not at all."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pytest

from frictool.adapters.parameter_intervals import absolute
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.log import Log, Stream
from frictool.observe.combined_estimator import FIELDS
from frictool.observe.wear.wear_estimator import prior
from frictool.observe.wear_estimate import EstimateRange
from studies.command_line import CommandResult, run
from studies.rigs.clutch_fleet import Unit, believed, clutch, with_encoder
from studies.rigs.fleet_logs import cut, log_of, model_file, repeated, save
from tests.support.command_line import also_called, refused
from tests.support.example_observers import drawn_observer

SECONDS = 6.0


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimpleNamespace]:
    """A model, and logs of a clutch that is as the model says and of one whose friction is 1.4
    times that."""
    folder = tmp_path_factory.mktemp("rig")
    new, worn = log_of(Unit(), 1, SECONDS), log_of(Unit(wear=1.4), 2, SECONDS)
    model = model_file(folder)
    return SimpleNamespace(
        folder=folder,
        model=model,
        new=save(new, folder / "new.mcap"),
        worn=save(worn, folder / "worn.mcap"),
        log=worn,
    )


def observe(*arguments: str | Path) -> CommandResult:
    return run("observe", "run", *arguments)


def found(*arguments: str | Path, code: int = 0) -> dict[str, object]:
    result = observe(*arguments, "--json")
    assert result.code == code, result.stderr
    return json.loads(result.stdout)


def test_the_estimates_are_a_log_with_units_and_provenance(
    rig: SimpleNamespace, tmp_path: Path
) -> None:
    result = observe(rig.model, rig.worn, "-o", tmp_path / "found.mcap", "--confidence", "0.9")
    assert result.code == 0, result.stderr
    log = read_mcap(tmp_path / "found.mcap")
    (stream,) = log.streams
    assert tuple(stream.signals) == FIELDS
    assert [
        stream.units[name] for name in ("position", "velocity_low", "friction_high", "wear")
    ] == ["rad", "rad/s", "N m", "1"]
    np.testing.assert_allclose(stream.time, rig.log.main.time, atol=1e-12)
    np.testing.assert_array_equal(stream.signals["position"], rig.log.main.signals["position"])
    for name in ("velocity", "friction", "wear"):
        value, low, high = (stream.signals[name + end] for end in ("", "_low", "_high"))
        assert (low <= value).all()
        assert (value <= high).all()
    assert (
        log.metadata["provenance"]["command"]
        == "frictool observe run model.yaml worn.mcap --confidence 0.9"
    )
    assert json.loads(log.metadata["estimate"]["wear"])["value"] == stream.signals["wear"][-1]


def test_the_text_has_absolute_intervals(rig: SimpleNamespace) -> None:
    """They include every constant of the bench's range, and a ratio needs none."""
    result = observe(rig.model, rig.worn)
    wear = found(rig.model, rig.worn)["wear"]
    constant = load(rig.model, Model).bench.actuator.constant
    low, high = absolute(wear["low"], wear["high"], constant)
    assert low < wear["low"] < wear["high"] < high
    (line,) = (one for one in result.stdout.splitlines() if one.startswith("wear  "))
    assert f"absolute [{low:.4g}, {high:.4g}]" in line


def test_a_worn_clutch_is_told_and_a_new_one_too(rig: SimpleNamespace) -> None:
    worn, new = found(rig.model, rig.worn), found(rig.model, rig.new)
    for facts, wear in ((worn, 1.4), (new, 1.0)):
        assert abs(facts["wear"]["value"] / wear - 1.0) < 0.02
        assert facts["wear"]["low"] < wear < facts["wear"]["high"]
        assert facts["moves"] >= 8
        assert facts["alarm"] is None
        assert facts["velocity_rms_true"] < facts["velocity_rms_filter_true"]
        assert (facts["samples"], facts["duration_s"], facts["gaps"]) == (
            SECONDS * 1000,
            SECONDS,
            0,
        )
    assert worn["wear"]["low"] > new["wear"]["high"]


def test_what_stands_at_a_sample_was_known_at_it(rig: SimpleNamespace, tmp_path: Path) -> None:
    # the first half of the log alone says the same of the first half: nothing comes from later
    observe(rig.model, rig.worn, "-o", tmp_path / "whole.mcap")
    observe(rig.model, rig.worn, "--to", "2.9", "-o", tmp_path / "half.mcap")
    whole, half = (read_mcap(tmp_path / name).main for name in ("whole.mcap", "half.mcap"))
    kept = half.time < 2.85  # the end of a log is the end of a move too
    assert kept.sum() > 2800
    for name in FIELDS:
        np.testing.assert_array_equal(
            half.signals[name][kept], whole.signals[name][: half.time.size][kept], err_msg=name
        )
    before = prior(believed())
    assert (
        EstimateRange(
            *(float(whole.signals[name][0]) for name in ("wear", "wear_low", "wear_high"))
        )
        == before
    )
    changes = np.flatnonzero(np.diff(whole.signals["wear"]))
    assert changes.size >= 8


def test_friction_is_what_the_motion_asks_for(rig: SimpleNamespace, tmp_path: Path) -> None:
    # effort less inertia times acceleration, over ten samples of a simulation that knows the
    # velocity
    observe(rig.model, rig.worn, "-o", tmp_path / "found.mcap")
    estimated, true = read_mcap(tmp_path / "found.mcap").main.signals, rig.log.main
    inertia = believed().parameters.inertia.value / 0.8
    velocity, effort, span = true.signals["velocity"], true.signals["effort"], 10
    starts = np.arange(2000, velocity.size - span)  # some moves have been seen
    moving = np.array([np.abs(velocity[k : k + span + 1]).min() > 40.0 for k in starts])
    asked = [
        effort[k : k + span].mean() - inertia * (velocity[k + span] - velocity[k]) / (span * 1e-3)
        for k in starts[moving]
    ]
    mean = {
        end: np.array([estimated["friction" + end][k : k + span].mean() for k in starts[moving]])
        for end in ("", "_low", "_high")
    }
    assert moving.sum() > 300
    assert np.sqrt(np.mean((mean[""] - asked) ** 2)) < 0.05 * np.mean(np.abs(asked))
    noise = 2.0 * 0.5 * 13.4e-3 / np.sqrt(span)
    assert np.mean((mean["_low"] - noise <= asked) & (asked <= mean["_high"] + noise)) > 0.95


def test_same_inputs_same_bytes(rig: SimpleNamespace, tmp_path: Path) -> None:
    for attempt in ("one", "two"):
        (tmp_path / attempt).mkdir()
        folder = tmp_path / attempt
        outputs = ("-o", folder / "found.mcap", "--plot", folder / "page.html")
        assert observe(rig.model, rig.worn, "--wear-limit", "1.5", *outputs).code == 0
    for name in ("found.mcap", "page.html"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_a_limit_is_a_verdict_with_its_exit_code(rig: SimpleNamespace, tmp_path: Path) -> None:
    above = found(
        rig.model, rig.worn, "--wear-limit", "1.25", "-o", tmp_path / "found.mcap", code=1
    )
    assert above["alarm"] is True
    assert "1.25" in above["reason"]
    assert (tmp_path / "found.mcap").is_file()  # what was found is written all the same
    below = found(rig.model, rig.new, "--wear-limit", "1.25")
    assert below["alarm"] is False
    text = observe(rig.model, rig.worn, "--wear-limit", "1.25")
    assert text.code == 1
    assert sum("EXCEEDED" in line for line in text.stdout.splitlines()) == 1


def test_the_limit_is_one_of_the_ratio_to_commissioning(
    rig: SimpleNamespace, tmp_path: Path
) -> None:
    then = tmp_path / "then.json"
    then.write_text(observe(rig.model, rig.worn, "--json").stdout)
    for reference in (then, rig.worn):
        facts = found(rig.model, rig.worn, "--wear-limit", "1.25", "--commissioning", reference)
        assert facts["ratio"]["value"] == pytest.approx(1.0, abs=1e-9)
        assert facts["alarm"] is False
    ratio = found(rig.model, rig.new, "--commissioning", then)["ratio"]["value"]
    assert ratio == pytest.approx(1.0 / 1.4, rel=0.02)
    (tmp_path / "other.json").write_text('{"wear": {"value": 1}}')
    refused(
        observe(rig.model, rig.new, "--commissioning", tmp_path / "other.json"), 3, "other.json"
    )


def test_a_gap_is_told_and_nothing_is_moved_over_it(rig: SimpleNamespace, tmp_path: Path) -> None:
    twice = save(repeated(rig.log, 2), tmp_path / "twice.mcap")
    result = observe(rig.model, twice, "--json")
    assert "1 gap in time, the longest 1 s" in result.stderr
    facts = json.loads(result.stdout)
    assert facts["gaps"] == 1
    assert abs(facts["wear"]["value"] / 1.4 - 1.0) < 0.02
    once = found(rig.model, rig.worn)
    assert abs(facts["moves"] - 2 * once["moves"]) <= 2


def test_pictures_are_svg_or_a_page_with_the_verdict(rig: SimpleNamespace, tmp_path: Path) -> None:
    observe(rig.model, rig.worn, "--wear-limit", "1.25", "--plot", tmp_path / "wear.svg")
    svg = (tmp_path / "wear.svg").read_text()
    assert svg.startswith("<svg")
    for label in ("wear [1]", "friction [N m]", "velocity [rad/s]", "time [s]"):
        assert f">{label}<" in svg
    hostile = tmp_path / "<script>alert(1)<"
    hostile.mkdir()
    log = save(rig.log, hostile / "x&y<b>.mcap")
    observe(rig.model, log, "--wear-limit", "1.25", "--plot", tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert page.startswith("<!DOCTYPE html>")
    assert "x&amp;y&lt;b&gt;.mcap" in page
    assert "x&y<b>" not in page
    assert "is above 1.25" in page
    for name in ("wear", "kind", "inertia", "velocity"):
        assert f'<th scope="row">{name}</th><td>' in page


def test_another_observer_is_a_stream_beside(rig: SimpleNamespace, tmp_path: Path) -> None:
    for kind, name in (("multiplicative", "wear"), ("additive", "added")):
        (tmp_path / "observer.yaml").write_text(to_yaml(drawn_observer(0, kind)))
        facts = found(
            rig.model,
            rig.worn,
            "--observer",
            tmp_path / "observer.yaml",
            "-o",
            tmp_path / "found.mcap",
        )
        own, other = read_mcap(tmp_path / "found.mcap").streams
        assert (own.topic, other.topic) == ("/axis", "/axis/observer")
        assert tuple(other.signals) == ("position", "velocity", "friction", name)
        np.testing.assert_array_equal(own.time, other.time)
        assert facts["observer"]["kind"] == kind
        assert facts["observer"][name] == other.signals[name][-1]
        assert abs(facts["wear"]["value"] / 1.4 - 1.0) < 0.02
    slow = (
        (tmp_path / "observer.yaml")
        .read_text()
        .replace("sample_period_s: 0.001", "sample_period_s: 0.002", 1)
    )
    (tmp_path / "observer.yaml").write_text(slow)
    refused(
        observe(rig.model, rig.worn, "--observer", tmp_path / "observer.yaml"),
        3,
        "observer.yaml",
        "sample_period_s",
        "0.002",
    )


def test_standard_input_is_a_log(rig: SimpleNamespace) -> None:
    with mock.patch("sys.stdin", io.TextIOWrapper(io.BytesIO(rig.worn.read_bytes()))):
        piped = found(rig.model, "-")
    assert piped["wear"] == found(rig.model, rig.worn)["wear"]


def test_a_damaged_log_is_refused_and_salvaged_where_asked(
    rig: SimpleNamespace, tmp_path: Path
) -> None:
    damaged = cut(save(repeated(rig.log, 3), tmp_path / "damaged.mcap"), 0.7)
    output = tmp_path / "found.mcap"
    refused(observe(rig.model, damaged, "-o", output), 3, "damaged.mcap", "cut off", "--salvage")
    assert not output.exists()
    result = observe(rig.model, damaged, "--salvage", "-o", output, "--json")
    assert result.code == 3
    assert "data were lost" in result.stderr
    assert len(json.loads(result.stdout)["lost"]) >= 1
    assert "lost" in read_mcap(output).metadata


def test_refusals_are_one_line_and_touch_nothing(rig: SimpleNamespace, tmp_path: Path) -> None:
    data = rig.worn.read_bytes()
    refused(observe(rig.model, rig.worn, "-o", rig.worn), 3, "is an input")
    refused(
        observe(
            rig.model,
            rig.worn,
            "--plot",
            rig.model.with_suffix(".svg"),
            "-o",
            also_called(rig.model, ".mcap"),
        ),
        3,
        "is an input",
    )
    refused(observe(rig.model, tmp_path / "none.mcap"), 3, "none.mcap", "no such file")
    refused(observe(tmp_path / "none.yaml", rig.worn), 3, "none.yaml")
    refused(observe(rig.model, rig.worn, "--stream", "/axis/other"), 3, "/axis/other")
    refused(observe(rig.model, rig.worn, "--from", "100"), 3, "has no samples from 100 s")
    assert rig.worn.read_bytes() == data
    for arguments, word in (
        (("--plot", "wear.png"), "allowed endings: .svg, .html or .htm"),
        (("--confidence", "1.5"), "confidence"),
        (("--wear-limit", "nan"), "allowed: a finite number"),
        (("--unit", "(U"), "not a regular expression"),
        (("--from", "3", "--to", "2"), "--from 3 is after --to 2"),
    ):
        result = observe(rig.model, rig.worn, *arguments)
        assert result.code == 2
        assert word in result.stderr


def test_a_log_that_tells_nothing_says_so(rig: SimpleNamespace, tmp_path: Path) -> None:
    (stream,) = rig.log.streams
    still = {name: np.zeros(stream.time.size) for name in ("position", "current")}
    log = Log((Stream("/axis", stream.time, still, {"position": "rad", "current": "A"}),), {})
    result = observe(
        rig.model,
        save(log, tmp_path / "still.mcap"),
        "--wear-limit",
        "1.25",
        "-o",
        tmp_path / "found.mcap",
        "--json",
    )
    facts = json.loads(result.stdout)
    assert result.code == 1
    words = (rig.model, tmp_path / "still.mcap", "--wear-limit", "1.25")
    assert "UNDECIDED: no move determines" in observe(*words).stdout
    assert observe(*words, "--allow-undecided").code == 0
    assert observe(*words[:2]).code == 0
    fleet = observe(*words, "-o", tmp_path / "fleet.csv")
    assert (fleet.code, fleet.stdout.splitlines()[0]) == (
        1,
        "1 log; above the limit 1.25: 0; undecided: 1",
    )
    assert observe(*words, "--allow-undecided", "-o", tmp_path / "fleet.csv").code == 0
    assert "no move determines the wear" in result.stderr
    assert (facts["moves"], facts["alarm"]) == (0, None)
    assert facts["wear"]["low"] < 1.0 < facts["wear"]["high"]
    signals = read_mcap(tmp_path / "found.mcap").main.signals
    assert all(np.isfinite(values).all() for values in signals.values())
    assert not signals["velocity"].any()


def test_a_model_without_dry_friction_is_refused(rig: SimpleNamespace, tmp_path: Path) -> None:
    text = rig.model.read_text()
    model = tmp_path / "model.yaml"
    lines, within = [], False
    for line in text.splitlines():  # the parameters alone, without the laws that scale them
        within = line.startswith("laws:") or (within and line.startswith((" ", "-")))
        if not within:
            lines.append(line)
    flat = (
        "\n".join(lines).replace("value: 0.12192", "value: 0").replace("value: 0.13411", "value: 0")
    )
    model.write_text(flat + "\n")
    refused(observe(model, rig.worn), 3, "friction")


@pytest.mark.parametrize("noise", [0.05, 0.5])
def test_the_stated_rate_of_the_velocity_holds_with_a_fine_encoder(
    noise: float, tmp_path: Path
) -> None:
    """Intervals of 95 % that leave out the drive's noise held 77 % at 0.05 A and 60 % at 0.5 A."""
    log = log_of(Unit(counts=4096.0), 1, SECONDS, noise)
    path, model = (
        save(log, tmp_path / "fine.mcap"),
        model_file(tmp_path, with_encoder(clutch(), 4096.0)),
    )
    assert observe(model, path, "-o", tmp_path / "found.mcap").code == 0
    signals, true = read_mcap(tmp_path / "found.mcap").main.signals, log.main.signals["velocity"]
    inside = (signals["velocity_low"] <= true) & (true <= signals["velocity_high"])
    assert 0.94 <= inside[true != 0.0].mean() <= 0.995
