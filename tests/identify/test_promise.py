"""`identify --promise`: a promise that is kept, and the reasons where it is not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from msgspec import structs

from frictool.documents.bench import Bench
from frictool.documents.laws import FrictionOverPosition, Laws, Polynomial
from frictool.documents.promise import Promise
from frictool.documents.quantity import Span
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.errors import InputFileError
from frictool.identify.from_logs import IdentifiedModel, identify
from frictool.identify.promise_comparison import PromisedParameter, compare_with_promise
from frictool.logs.log import Log
from frictool.logs.log_reader import read_log
from frictool.simulate import play
from frictool.simulate.default_servo import default_servo, feedforward
from studies.command_line import run_checked
from studies.promises.rigs import benches, truth

# `make accept` tests how often promises are kept (tests/accept/check_promises.py)
WANTED = {"inertia": 0.02, "coulomb": 0.02}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory, no_rehearsals: None) -> Path:
    """A folder with bench.yaml, test.mcap and promise.yaml."""
    folder = tmp_path_factory.mktemp("belt")
    bench, test, promise = (folder / name for name in ("bench.yaml", "test.mcap", "promise.yaml"))
    bench.write_text(to_yaml(next(one for one in benches() if one.name == "belt")))
    wanted = [word for name in WANTED for word in ("--for", f"{name}=2%")]
    run_checked("excite", "--bench", bench, *wanted, "-o", test, "--promise", promise)
    return folder


@pytest.fixture(scope="module")
def belt(files: Path) -> tuple[Bench, Log, Promise]:
    return (
        load(files / "bench.yaml", Bench),
        read_log(files / "test.mcap"),
        load(files / "promise.yaml", Promise),
    )


def compared(
    belt: tuple[Bench, Log, Promise], noise: float, share: float = 1.0
) -> dict[str, PromisedParameter]:
    bench, _, promise = belt
    return by_name(compare_with_promise(identified(belt, noise, share), bench, promise))


def by_name(rows: list[PromisedParameter]) -> dict[str, PromisedParameter]:
    return {row.parameter: row for row in rows}


def identified(
    belt: tuple[Bench, Log, Promise], noise: float, share: float = 1.0
) -> IdentifiedModel:
    bench, sequence, _ = belt
    stream = sequence.main
    kept = int(share * stream.time.size)
    short = replace(
        stream,
        time=stream.time[:kept],
        signals={name: values[:kept] for name, values in stream.signals.items()},
    )
    sequence = replace(sequence, streams=(short,))
    log = play(
        truth(bench, 0),
        sequence,
        servo=default_servo(bench),
        drive_noise=noise,
        forward=feedforward(bench, sequence),
    )
    return identify([log], bench)


def test_a_log_of_the_test_keeps_the_promise(belt: tuple[Bench, Log, Promise]) -> None:
    rows = compared(belt, noise=0.02)
    assert set(rows) == set(WANTED)
    assert all(row.kept and not row.reasons for row in rows.values())
    assert "kept" in rows["inertia"].line()


def test_more_noise_is_named(belt: tuple[Bench, Log, Promise]) -> None:
    rows = compared(belt, noise=0.5)
    assert not rows["coulomb"].kept
    assert any("the measured drive has a noise of 0.5" in one for one in rows["coulomb"].reasons)
    assert "missed" in rows["coulomb"].line()


def test_an_effect_that_the_logs_show_is_the_one_reason(belt: tuple[Bench, Log, Promise]) -> None:
    """Noise and strokes are as planned; friction over position is not in the simulations."""
    bench, _, promise = belt
    outcome = identified(belt, noise=0.02)
    curve = Polynomial((1.0, 0.5))
    laws = Laws(position=FrictionOverPosition(Span(0.0, 1.0, "m"), curve))
    result = replace(outcome.result, laws=laws, refused={"coulomb": "not shown"})
    known = {"inertia": outcome.result.identified["inertia"]}
    varied = replace(outcome, result=replace(result, identified=known))
    half = 0.1 * known["inertia"].half_width
    strict = structs.replace(
        promise,
        half_widths=structs.replace(
            promise.half_widths, inertia=structs.replace(promise.half_widths.inertia, value=half)
        ),
    )
    rows = by_name(compare_with_promise(varied, bench, strict))
    shown = "the logs show friction over position, which the promise does not contain"
    assert rows["inertia"].reasons == (shown,)
    assert rows["coulomb"].reasons == ("not shown", shown)
    assert len(rows["inertia"].line()) <= 190


def test_a_short_log_is_named(belt: tuple[Bench, Log, Promise]) -> None:
    rows = compared(belt, noise=0.05, share=0.3)
    missed = [row for row in rows.values() if not row.kept]
    assert missed
    for row in missed:
        assert any("the logs last" in one for one in row.reasons)
        assert row.view()["kept"] is False


def test_a_promise_of_another_bench_is_refused(belt: tuple[Bench, Log, Promise]) -> None:
    bench, test, promise = belt
    other = next(one for one in benches() if one.name == "arm")
    log = play(
        truth(bench, 0),
        test,
        servo=default_servo(bench),
        drive_noise=0.02,
    )
    with pytest.raises(
        InputFileError, match=r"belongs to the bench belt \(linear\); allowed: a promise of arm"
    ):
        compare_with_promise(identify([log], bench), other, promise)


def test_command_compares(files: Path, belt: tuple[Bench, Log, Promise], tmp_path: Path) -> None:
    model, log = tmp_path / "truth.yaml", tmp_path / "log.mcap"
    model.write_text(to_yaml(truth(belt[0], 0)))
    run_checked("simulate", "--as-bench", model, files / "test.mcap", "-o", log)
    inputs = ("--bench", files / "bench.yaml", "--promise", files / "promise.yaml")
    assert "inertia: promised +-" in run_checked("identify", log, *inputs)
    rows = json.loads(run_checked("identify", log, *inputs, "--json"))["promise"]
    assert {row["parameter"]: row["kept"] for row in rows} == dict.fromkeys(WANTED, True)
