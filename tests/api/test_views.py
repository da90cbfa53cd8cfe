"""Documents and results at the Python prompt: text, HTML, comparison, data frames, figures."""

from __future__ import annotations

import dataclasses
import math
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from matplotlib.figure import Figure

from frictool.documents import load
from frictool.errors import LogError
from frictool.logs import log_of
from frictool.logs.log import Log, Stream
from frictool.report import judge
from frictool.report.stream_selection import select_streams
from frictool.runtime.object_view import LONGEST, MOST_ROWS, ObjectView, same
from frictool.simulate import simulate
from studies.rigs.clutch_model import ROOT, clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller, scenario
from studies.rigs.verified_controller import truthful

DOCUMENTS = [
    "configs/clutch/bench.yaml",
    "configs/clutch/spec.yaml",
    "configs/clutch/mechanism.yaml",
]

SCENARIO = msgspec.structs.replace(scenario(), variants="vertices")


@pytest.fixture(scope="module")
def run() -> Log:
    return simulate(clutch_model(), truthful(controller()), SCENARIO)


@pytest.mark.parametrize("path", DOCUMENTS)
def test_a_document_is_one_line_and_one_table(path: str) -> None:
    document = load(ROOT / path)
    assert repr(document).startswith(f"{type(document).__name__}(name=")
    assert len(repr(document)) <= LONGEST + 40
    assert document._repr_html_().startswith(f"<table><caption>{type(document).__name__}")


def test_text_of_a_document_is_escaped() -> None:
    bench = load(ROOT / "configs/clutch/bench.yaml")
    shown = msgspec.structs.replace(bench, name="<script>")._repr_html_()
    assert "<script>" not in shown
    assert "&lt;script&gt;" in shown


def test_a_stream_is_a_data_frame(run: Log) -> None:
    frame = run.main.to_pandas()
    assert frame.index.name == "time"
    assert list(frame.columns) == list(run.main.signals)
    assert frame.attrs["units"] == run.main.units
    for name, values in run.main.signals.items():
        np.testing.assert_array_equal(frame[name].to_numpy(), values)
    np.testing.assert_array_equal(frame.index.to_numpy(), run.main.time)


def test_a_data_frame_without_pandas_names_the_extra(
    run: Log, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(LogError, match=r"pip install 'frictool\[pandas\]'"):
        run.main.to_pandas()


def test_results_are_compared_by_value(run: Log) -> None:
    again = simulate(clutch_model(), truthful(controller()), SCENARIO)
    assert again == run
    changed = {name: values.copy() for name, values in run.main.signals.items()}
    changed["position"][-1] = math.nextafter(changed["position"][-1], math.inf)
    streams = (dataclasses.replace(run.main, signals=changed), *run.streams[1:])
    assert dataclasses.replace(run, streams=streams) != run
    assert judge(clutch_spec(), [run]) == judge(clutch_spec(), [again])
    assert run != "a log"


def test_nan_equals_nan_and_types_differ() -> None:
    nan = np.array([1.0, math.nan])
    units = {"position": "rad"}
    assert Stream("/axis", nan, {"position": nan}, units) == Stream(
        "/axis", nan.copy(), {"position": nan.copy()}, units
    )
    assert same((math.nan, {"a": [1]}), (math.nan, {"a": [1]}))
    assert not same(np.array([1.0]), np.array([1]))
    assert not same(1.0, 1)
    assert not same({"a": 1}, {"b": 1})


@dataclasses.dataclass(frozen=True, repr=False)
class Points(ObjectView):
    rows: tuple[ObjectView, ...]


def test_long_tables_say_what_they_leave_out() -> None:
    shown = Points(tuple(Points(()) for _ in range(MOST_ROWS + 3)))._repr_html_()
    assert shown.count("<tr>") == 1 + 1 + MOST_ROWS + 1
    assert "3 more" in shown


def test_figures_show_what_they_are_of(run: Log, tmp_path: Path) -> None:
    figure = run.plot()
    assert isinstance(figure, Figure)
    assert [axes.get_ylabel() for axes in figure.axes] == [
        f"{name} [{run.main.units[name]}]" for name in run.main.signals
    ]
    assert {len(axes.lines) for axes in figure.axes} == {len(run.axes)}
    model = clutch_model().plot()
    (forward, *_) = model.axes
    assert "N m" in forward.get_ylabel()
    verdict = judge(clutch_spec(), [run])
    position, drive = verdict.plot().axes
    assert verdict.state in position.get_title(loc="left")
    assert drive.get_ylabel() == "current [A]"
    lines = {line.get_label(): line for line in position.lines}
    worst = next(item for item, _ in select_streams(verdict) if item.worst)
    plants = [line for name, line in lines.items() if name != "reference"]
    assert max(plants, key=lambda line: line.get_zorder()) is lines[worst.plant]
    for one in (figure, model, position.figure):
        one.savefig(tmp_path / "figure.png")


def test_a_log_from_arrays_has_a_plot() -> None:
    assert log_of([0.0, 1.0], {"position": [0.0, 1.0]}, "rotary").plot().axes
