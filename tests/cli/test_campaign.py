"""`frictool campaign` as a shell sees it."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

from frictool.campaign.draws.sampling import draws_of
from frictool.campaign.trials import trial_player
from frictool.documents.quantity import Quantity, Span
from frictool.documents.spread import InstantBand, LastingBand, Spread, SpreadDisturbance
from frictool.documents.writing import to_yaml
from studies.command_line import run
from studies.rigs.campaign_rig import EVERYTHING, played, trial, write
from tests.support.command_line import refused
from tests.support.simulated_mechanisms import ONE_BLOCK

NO_REST = {"rest": None}  # the step is too short for it
WEAR = Spread(
    parameters={"inertia": Span(1.2e-5, 1.2e-5, "kg m^2")}, wear=EVERYTHING.wear, within_count=True
)

FIXED = (
    ("inertia", 1.32e-5, "kg m^2"),
    ("viscous", 3.81e-4, "N m s/rad"),
    ("coulomb", 0.099, "N m"),
    ("constant", 13.4e-3, "N m/A"),
    ("breakaway", 0.109, "N m"),
)


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_each_trial_has_the_numbers_of_simulate_and_report(tmp_path: Path) -> None:
    """Its scenario, written to a file, played, logged, read and judged, gives the same bits."""
    command = write(tmp_path, played(EVERYTHING))
    assert run(*command, "-n", "3", "--cores", "1", "--table", tmp_path / "trials.csv").code in (
        0,
        1,
    )
    rows, files = rows_of(tmp_path / "trials.csv"), (tmp_path / "one.yaml", tmp_path / "run.mcap")
    space = trial(EVERYTHING).space
    for draw, unit in enumerate(draws_of("random", 3, space.size, 3).units):
        files[0].write_text(to_yaml(trial(EVERYTHING).scenario(unit, draw)))
        done = run(
            "simulate",
            tmp_path / "model.yaml",
            "--controller",
            tmp_path / "controller.yaml",
            "--scenario",
            files[0],
            "-o",
            files[1],
        )
        assert done.code == 0, done.stderr
        judged = run(
            "report",
            files[1],
            "--spec",
            tmp_path / "spec.yaml",
            "--controller",
            tmp_path / "controller.yaml",
            "--json",
        )
        assert not rows[draw]["not simulated"]
        for one in json.loads(judged.stdout)["requirements"]:
            found = next(
                text for key, text in rows[draw].items() if key.split(" [")[0] == one["name"]
            )
            assert {"met": True, "broken": False, "": None}[
                rows[draw][f"{one['name']} met"]
            ] == one["met"]
            if one["value"] is not None:
                assert float(found) == one["value"]


def test_results_depend_neither_on_processes_nor_on_what_was_played_before(tmp_path: Path) -> None:
    command = write(tmp_path, played(WEAR), **NO_REST)
    outputs = {}
    for cores in ("1", "2"):
        page, rows = tmp_path / f"{cores}.yaml", tmp_path / f"{cores}.csv"
        assert run(*command, "-n", "24", "--cores", cores, "-o", page, "--table", rows).code in (
            0,
            1,
        )
        outputs[cores] = [page.read_bytes(), rows.read_bytes()]
    assert outputs["1"] == outputs["2"]
    kept, rows = tmp_path / "kept.jsonl", tmp_path / "3.csv"
    for count in ("5", "24"):  # draws of a seed are the same however many there are
        done = run(*command, "-n", count, "--cores", "1", "--keep", kept, "--table", rows)
    assert "5 of 24 trials are stored" in done.stderr
    assert rows.read_bytes() == outputs["1"][1]


def test_worst_cases_are_worse_than_any_draw_and_replay_to_the_last_bit(tmp_path: Path) -> None:
    command = write(tmp_path, played(WEAR), **NO_REST)
    rows, worst = tmp_path / "rows.csv", tmp_path / "worst"
    result = run(
        *command,
        "-n",
        "10",
        "--cores",
        "1",
        "--table",
        rows,
        "--worst",
        worst,
        "--evaluations",
        "40",
        "--json",
    )
    told = {one["requirement"]: one for one in json.loads(result.stdout)["worst"]}
    assert set(told) == {
        "response_time_95",
        "overshoot",
        "static_error",
        "oscillations",
        "drive_peak",
        "modulus_margin",
    }
    for name, one in told.items():
        words = one["command"].replace("model.yaml", str(tmp_path / "model.yaml")).split()[1:]
        places = {
            "controller.yaml": tmp_path / "controller.yaml",
            one["scenario"]: worst / one["scenario"],
        }
        words = [
            str(places.get(word, tmp_path / word if word.endswith(".mcap") else word))
            for word in words
        ]
        assert run(*words).code == 0
        judged = run(
            "report",
            words[-1],
            "--spec",
            tmp_path / "spec.yaml",
            "--controller",
            tmp_path / "controller.yaml",
            "--json",
        )
        found = next(r for r in json.loads(judged.stdout)["requirements"] if r["name"] == name)
        assert (found["value"], found["met"]) == (one["value"], one["met"])
        drawn = [
            float(row[key]) for row in rows_of(rows) for key in row if key.split(" [")[0] == name
        ]
        if one["relation"] == ">=":
            assert one["value"] <= min(drawn)
        else:
            assert (one["value"] if one["value"] is not None else np.inf) >= max(drawn)
    assert told["static_error"]["value"] > max(
        float(row["static_error [rad]"]) for row in rows_of(rows)
    )


def test_what_cannot_be_simulated_is_counted_and_named(tmp_path: Path) -> None:
    """A stop that may lie before the start, on the other side of the other stop, or before the
    origin: each end is a mechanism."""
    command = write(tmp_path, played(), **NO_REST)
    command[1] = tmp_path / "mechanism.yaml"
    stops = ONE_BLOCK.replace("low: {value: 0,", "low: {value: -10, low: -20, high: 0,").replace(
        "{value: 63,", "{value: 63, low: -15, high: 63,"
    )
    (tmp_path / "mechanism.yaml").write_text(stops)
    result = run(
        *command,
        "-n",
        "30",
        "--seed",
        "0",
        "--cores",
        "1",
        "--table",
        tmp_path / "rows.csv",
        "--json",
    )
    assert result.code == 1, result.stderr
    rows, told = rows_of(tmp_path / "rows.csv"), json.loads(result.stdout)
    broken = [row for row in rows if float(row["links.ends.high [rad]"]) < 5.0]
    assert 0 < len(broken) < 30
    assert len(told["not_simulated"]) == len(broken)
    assert all(row["passed"] == "broken" for row in broken)
    reasons = {
        "`low` is not below `high`",
        "rotor starts at 0 rad; allowed",
        "plant given: the start puts rotor at 5 rad; allowed",
    }
    assert {
        reason for reason in reasons for row in broken if reason in row["not simulated"]
    } == reasons
    assert told["trials"] == 30


def test_a_kill_loses_little_and_the_same_command_goes_on(tmp_path: Path) -> None:
    command = write(tmp_path, played(WEAR), **NO_REST)
    asked, whole = ["-n", "90", "--cores", "1", "--seed", "9"], tmp_path / "whole.yaml"
    output, kept = tmp_path / "campaign.yaml", tmp_path / "campaign.yaml.trials"
    process = subprocess.Popen(
        [sys.executable, "-m", "frictool", *map(str, [*command, *asked, "-o", output])],
        stderr=subprocess.PIPE,
    )
    try:
        deadline = time.monotonic() + 120.0
        while not (kept.is_file() and kept.read_bytes().count(b"\n") > 20):
            assert process.poll() is None, process.stderr
            assert time.monotonic() < deadline
            time.sleep(0.005)
    finally:
        process.kill()
        process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert not output.exists()
    there = kept.read_bytes().count(b"\n") - 1
    assert 20 <= there < 90
    assert f"{there} of 90 trials are stored" in run(*command, *asked, "-o", output).stderr
    assert not kept.exists()
    run(*command, *asked, "-o", whole)
    assert output.read_bytes() == whole.read_bytes()


def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = write(tmp_path, played(WEAR), **NO_REST)
    original = trial_player.TrialPlayer.played

    def interrupted(
        self: trial_player.TrialPlayer, unit: np.ndarray, draw: int
    ) -> trial_player.TrialResult:
        if draw == 7:
            raise KeyboardInterrupt
        return original(self, unit, draw)

    monkeypatch.setattr(trial_player.TrialPlayer, "played", interrupted)
    output = tmp_path / "campaign.html"
    result = run(*command, "-n", "12", "--cores", "1", "-o", output)
    assert result.code == 130
    assert (
        f"7 of 12 trials are done; the same command continues from {output}.trials" in result.stderr
    )
    assert result.stdout == ""
    assert not output.exists()
    monkeypatch.setattr(
        trial_player.TrialPlayer, "nominal", lambda self: interrupted(self, np.zeros(1), 7)
    )
    before = run(
        *command, "-n", "12", "--cores", "1", "-o", tmp_path / "b.html"
    )  # before the first trial, as any other command
    assert (before.code, before.stderr.strip()) == (130, "interrupted")
    assert not (tmp_path / "b.html.trials").exists()
    monkeypatch.undo()
    assert (
        "7 of 12 trials are stored"
        in run(*command, "-n", "12", "--cores", "1", "-o", output).stderr
    )
    assert (
        "frictool campaign model.yaml controller.yaml --scenario scenario.yaml"
        in output.read_text()
    )


def test_vertices_of_a_mechanism(tmp_path: Path) -> None:
    """Every quantity with ends varies, by its key; each vertex is the mechanism with these
    values."""
    command = write(tmp_path, played(), **NO_REST)
    command[1] = tmp_path / "mechanism.yaml"
    ends = {
        "1.32e-5": "1.1e-5, high: 1.5e-5, value: 1.32e-5",
        "0.099": "0.02, high: 0.12, value: 0.099",
    }
    text = ONE_BLOCK
    for value, span in ends.items():
        text = text.replace(f"{{value: {value},", f"{{low: {span},")
    (tmp_path / "mechanism.yaml").write_text(text)
    result = run(
        *command,
        "--method",
        "vertices",
        "--cores",
        "1",
        "-o",
        tmp_path / "found.yaml",
        "--table",
        tmp_path / "rows.csv",
    )
    assert result.code in (0, 1), result.stderr
    found = yaml.safe_load((tmp_path / "found.yaml").read_text())
    assert [factor["name"] for factor in found["factors"]] == [
        "blocks.rotor.inertia",
        "links.bearing.parameters.coulomb",
    ]
    assert found["provenance"]["command"].endswith("--method vertices --confidence 0.95")
    (tmp_path / "given.yaml").write_text(
        to_yaml(
            played(
                variants="given",
                given={
                    "blocks.rotor.inertia": Quantity(value=1.1e-5, unit="kg m^2"),
                    "links.bearing.parameters.coulomb": Quantity(value=120.0, unit="mN m"),
                },
            )
        )
    )
    words = [
        "--controller",
        tmp_path / "controller.yaml",
        "--scenario",
        tmp_path / "given.yaml",
        "-o",
        tmp_path / "run.mcap",
    ]
    assert run("simulate", command[1], *words).code == 0
    judged = run("report", tmp_path / "run.mcap", "--spec", tmp_path / "spec.yaml", "--json")
    values = {one["name"]: one["value"] for one in json.loads(judged.stdout)["requirements"]}
    second = rows_of(tmp_path / "rows.csv")[1]  # the last factor changes first
    assert (float(second["overshoot [%]"]), float(second["static_error [rad]"])) == (
        values["overshoot"],
        values["static_error"],
    )


def test_a_requirement_that_no_trial_decides_makes_the_campaign_undecided(tmp_path: Path) -> None:
    """The step is too short for `rest`: every plant passes what the scenario decides, and the
    campaign does not pass."""
    loose = {"overshoot_percent": 1000.0, "static_error": None, "oscillations": None}
    command = [
        *write(tmp_path, played(WEAR), **loose),
        "--cores",
        "1",
        "-n",
        "4",
        "-o",
        tmp_path / "found.yaml",
    ]
    result = run(*command)
    assert result.code == 1
    assert result.stdout.splitlines()[-1].startswith("UNDECIDED: all 4 draws pass")
    assert result.stdout.splitlines()[-1].endswith("undecided in every trial: rest")
    assert yaml.safe_load((tmp_path / "found.yaml").read_text())["verdict"] == "undecided"
    allowed = run(*command, "--allow-undecided")
    assert (allowed.code, allowed.stdout) == (0, result.stdout)
    strict = write(
        tmp_path / "strict",
        played(WEAR),
        **(loose | {"overshoot_percent": 0.0, "response_time_95_s": 1e-3}),
    )
    failing = run(*strict, "--cores", "1", "-n", "4", "--allow-undecided", "--json")
    assert failing.code == 1
    assert json.loads(failing.stdout)["verdict"] == "fail"


def test_at_least_asks_for_a_rate_that_is_shown(tmp_path: Path) -> None:
    command = [
        *write(
            tmp_path,
            played(WEAR),
            **NO_REST,
            overshoot_percent=1000.0,
            static_error=None,
            oscillations=None,
        ),
        "--cores",
        "1",
        "-n",
        "30",
    ]
    assert run(*command).code == 0
    assert run(*command, "--at-least", "0.9").code == 0
    result = run(*command, "--at-least", "0.95")
    assert result.code == 1
    assert "NOT SHOWN" in result.stdout


@pytest.mark.parametrize(
    ("spread", "words"),
    [
        (
            Spread(parameters={"coulom": Span(0.0, 1.0, "N m")}),
            ("spread.parameters.coulom", "no such parameter", "coulomb"),
        ),
        (
            Spread(parameters={"coulomb": Span(0.0, 1.0, "kg")}),
            ("spread.parameters.coulomb.unit", "allowed: N m"),
        ),
        (
            Spread(parameters={"coulomb": Span(-20.0, 60.0, "mN m")}),
            (
                "scenario.yaml:12: spread.parameters.coulomb.low: found -20 mN m; a plant with "
                "this value cannot be simulated: coulomb is -0.02; allowed: >= 0",
            ),
        ),
        (
            Spread(parameters={"inertia": Span(0.0, 2e-5, "kg m^2")}),
            ("spread.parameters.inertia.low: found 0 kg m^2", "allowed: > 0"),
        ),
        (
            Spread(parameters={"breakaway": Span(-0.01, 0.3, "N m")}),
            (
                "spread.parameters.breakaway.low: found -0.01 N m, below 0; allowed: at least 0, "
                "because its lower limit is proportional to Coulomb friction",
            ),
        ),
        (
            Spread(parameters={"breakaway": Span(50.0, 60.0, "mN m")}),
            (
                "parameters.breakaway: found 0.05 to 0.06 N m, below Coulomb friction of up to "
                "0.18 N m; allowed: at least the",
            ),
        ),
        (
            Spread(start=Span(-5.0, 9.0, "rad")),
            ("spread.start", "allowed: the travel of the bench, 0 to 63"),
        ),
        (
            Spread(
                disturbances=(
                    SpreadDisturbance(
                        "pulse", Span(0, 1, "N m"), InstantBand(0, 0.7), LastingBand(0.1, 0.2)
                    ),
                )
            ),
            ("spread.disturbances[0].at_s", "found 0.7, after the end"),
        ),
        (
            Spread(
                disturbances=(
                    SpreadDisturbance(
                        "pulse", Span(0, 1, "N m"), InstantBand(0, 0.5), LastingBand(0.1, 0.2)
                    ),
                )
            ),
            ("spread.disturbances[0].duration_s", "may end at 0.7 s, after the end"),
        ),
        (
            Spread(disturbances=(SpreadDisturbance("step", Span(0, 1, "N")),)),
            ("spread.disturbances[0].effort.unit", "allowed: N m"),
        ),
        (
            Spread(disturbances=(SpreadDisturbance("step", Span(0, 1, "N m"), on="rotor"),)),
            ("spread.disturbances[0].on", "model.yaml is one axis; leave the key out"),
        ),
    ],
)
def test_what_does_not_fit_is_told_before_anything_is_played(
    tmp_path: Path, spread: Spread, words: tuple[str, ...]
) -> None:
    result = run(*write(tmp_path, played(spread)), "-n", "5", "-o", tmp_path / "out.yaml")
    refused(result, 3, "scenario.yaml:", *words)
    assert not (tmp_path / "out.yaml.trials").exists()


def test_wrong_command_lines_and_files(tmp_path: Path) -> None:
    command = write(tmp_path, played(WEAR))
    assert "belongs to --worst" in run(*command, "--evaluations", "5").stderr
    assert (
        "give two names"
        in run(*command, "-o", tmp_path / "a.yaml", "--keep", tmp_path / "a.yaml").stderr
    )
    refused(run(*command, "-n", "5", "-o", tmp_path / "model.yaml"), 3, "model.yaml: is an input")
    refused(run(*command, "-n", "5", "-o", tmp_path), 3, "is a directory")
    refused(
        run(*command, "-n", "5", "--worst", tmp_path / "spec.yaml"), 3, "spec.yaml: is not a folder"
    )
    for option in ("-o", "--keep", "--worst"):  # before anything is played
        refused(
            run(*command, "-n", "5", option, tmp_path / "spec.yaml" / "x.yaml"),
            3,
            "cannot be written",
        )
    for option, value in (
        ("-n", "0"),
        ("--at-least", "0"),
        ("--at-least", "nan"),
        ("--confidence", "1"),
        ("--cores", "0"),
    ):
        assert run(*command, option, value).code == 2
    refused(run(*command[:4], tmp_path / "none.yaml", *command[5:]), 3, "none.yaml: no such file")
    refused(run(*command[:4], tmp_path / "spec.yaml", *command[5:]), 3, "spec.yaml:1: format")


def test_a_campaign_of_nothing_is_refused(tmp_path: Path) -> None:
    fixed = Spread(parameters={name: Span(value, value, unit) for name, value, unit in FIXED})
    refused(run(*write(tmp_path, played(fixed))), 3, "scenario.yaml:", "spread: nothing varies")
    names = (
        "response_time_95_s",
        "overshoot_percent",
        "static_error",
        "oscillations",
        "modulus_margin",
        "drive_peak",
        "rest",
    )
    refused(
        run(*write(tmp_path, played(WEAR), **dict.fromkeys(names))),
        3,
        "spec.yaml: has no requirement that a run can decide",
    )
