"""Tables of single breakaways over the rate of the ramp: means, their rise, and wrong tables."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.errors import LogError
from frictool.identify.breakaway.rate_table import RateTable, breakaway_over_rate, read_rate_table
from studies.command_line import run
from tests.identify.arm import PERIOD, Arm, play, write_bench, write_log
from tests.support.command_line import refused

RATES = np.array([0.05, 0.1, 0.2, 0.5])


def drawn(seed: int, rise: float = 0.1, scatter: float = 0.02, number: int = 8) -> RateTable:
    """Breakaways of 0.4 N m at a rate of 0.1, `rise` N m higher a decade."""
    draw = np.random.default_rng([seed, 5])
    rate = np.repeat(RATES, number)
    effort = 0.4 + rise * np.log10(rate / 0.1) + scatter * draw.standard_normal(rate.size)
    return RateTable("drawn", effort, rate)


def write(target: Path, table: RateTable, row: str = "{effort:.6f} {rate:g}\n") -> Path:
    """Write a table; `row`: the form of a line."""
    pairs = zip(table.effort, table.rate, strict=True)
    target.write_text("".join(row.format(effort=effort, rate=rate) for effort, rate in pairs))
    return target


def test_means_and_rise_cover() -> None:
    """Of 200 tables, 95 % of the intervals of a mean and of the rise contain the truth; binomial,
    fewer than 180 once in a thousand."""
    means = rises = 0
    for seed in range(200):
        found = breakaway_over_rate(drawn(seed), 0.95)
        one = found.rates[1].mean
        means += one.low <= 0.4 <= one.high
        assert found.per_decade is not None
        rises += found.per_decade.low <= 0.1 <= found.per_decade.high
    assert means >= 180
    assert rises >= 180


@pytest.mark.parametrize(
    ("head", "row"),
    [
        ("", "{effort:.6f} {rate:g}\n"),
        ("", "{effort:.6f}\t{rate:g}\n\n"),
        ("effort,rate\n", "{effort:.6f},{rate:g}\n"),
        ("Effort [N m], rate (N m/s)\n", "{effort:.6f},{rate:g}\n"),
        ('"rate";"effort"\n', "{rate:g};{effort:.6f}\n"),
        ("", "-{effort:.6f}, {rate:g}\n"),
    ],
)
def test_every_form_of_a_table_is_read_alike(tmp_path: Path, head: str, row: str) -> None:
    """A breakaway in the other direction counts by its size."""
    table = drawn(1)
    path = write(tmp_path / "table.csv", table, row)
    path.write_text(head + path.read_text())
    read = read_rate_table(path)
    assert read.effort == pytest.approx(table.effort, abs=1e-6)
    assert read.rate == pytest.approx(table.rate)


def test_another_unit_of_the_effort_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text("rate,effort [mN m]\n1,400\n2,410\n3,420\n")
    with pytest.raises(LogError, match=r"line 1: found the unit 'mN m' of the effort; allowed"):
        read_rate_table(path)


def identified(folder: Path, table: Path, *options: str):
    """Identify an arm from a driven log and a table."""
    arm = Arm(inertia=0.02, viscous=0.04, coulomb=0.3, breakaway=0.36)
    time = np.arange(8000) * PERIOD
    position, effort = play(arm, 0.7 * np.sin(4.0 * time) + 0.5 * np.sin(7.1 * time))
    noise = 1e-3 * np.random.default_rng(2).standard_normal(effort.size)
    log = write_log(folder / "driven.csv", position, effort + noise)
    bench = write_bench(folder, arm)
    model = folder / "model.yaml"
    given = ("--bench", bench, "--method", "least-squares", "--breakaway-table", table)
    return run("identify", log, *given, "-o", model, *options)


def test_the_model_has_the_breakaway_of_all_rates(tmp_path: Path) -> None:
    """Its interval reaches over the rates; the text says that it rises."""
    table = write(tmp_path / "table.csv", drawn(3))
    result = identified(tmp_path, table, "--json")
    assert result.code == 0, result.stderr
    facts = json.loads(result.stdout)
    one = facts["parameters"]["breakaway"]
    assert one["low"] <= 0.4 + 0.1 * np.log10(0.5)
    assert one["high"] >= 0.4 + 0.1 * np.log10(5.0)
    assert [row["count"] for row in facts["breakaway_over_rate"]["rates"]] == [8, 8, 8, 8]
    text = identified(tmp_path, table).stdout
    assert "breakaway rises with the rate" in text
    assert "table.csv" in (tmp_path / "model.yaml").read_text()


def test_a_breakaway_below_coulomb_friction_is_refused(tmp_path: Path) -> None:
    """Coulomb friction is 0.3 N m."""
    low = drawn(4)
    table = write(tmp_path / "table.csv", RateTable("low", 0.1 * low.effort, low.rate))
    result = identified(tmp_path, table, "--json")
    facts = json.loads(result.stdout)
    assert "breakaway" not in facts["parameters"]
    assert "breakaway" in facts["not_identified"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0.4 0.1\n0.4 slow\n", ("line 2", "slow", "effort and rate")),
        ("0.4 0.1\n0.5 -1\n", ("line 2", "rate -1", "above 0")),
        ("0.4 0.1\nnan 0.1\n", ("line 2", "finite")),
        ("0.4\n", ("line 1",)),
        ("", ("has 0 breakaways",)),
        ("0.4 0.1\n0.5 0.2\n", ("one breakaway at each rate",)),
        ("\x00\x01", ("line 1",)),
    ],
)
def test_a_wrong_table_is_an_input_error(tmp_path: Path, text: str, words: tuple[str, ...]) -> None:
    """One line with the place."""
    table = tmp_path / "table.csv"
    table.write_text(text)
    refused(identified(tmp_path, table), 3, "table.csv", *words)


def test_ramps_and_a_table_exclude_each_other(tmp_path: Path) -> None:
    """Both give the breakaway."""
    table = write(tmp_path / "table.csv", drawn(1))
    assert identified(tmp_path, table, "--ramp", table).code == 2
