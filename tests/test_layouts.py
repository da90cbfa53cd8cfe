"""The layouts for Foxglove and PlotJuggler name what a simulated run has, in the structure that
those programs read."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest

from frictool.logs.canonical.mcap_format import read_mcap
from studies.command_line import run
from studies.rigs.step_scenario import write_rig

LAYOUTS = Path(__file__).parents[1] / "configs" / "layouts"
SHOWN = {"position", "reference", "velocity", "current"}


@pytest.fixture(scope="module")
def series(tmp_path_factory: pytest.TempPathFactory) -> set[tuple[str, str]]:
    """(topic, field) of every signal of a run."""
    folder = tmp_path_factory.mktemp("run")
    rig = write_rig(folder)
    target = folder / "run.mcap"
    done = run(
        "simulate",
        rig["model"],
        "--controller",
        rig["controller"],
        "--scenario",
        rig["scenario"],
        "-o",
        target,
    )
    assert done.code == 0, done.stderr
    return {(stream.topic, name) for stream in read_mcap(target).streams for name in stream.signals}


def panels(layout: Any) -> list[str]:
    """The panels of a tree of splits, from first to second."""
    if isinstance(layout, str):
        return [layout]
    assert layout["direction"] in ("row", "column")
    assert 0 < layout["splitPercentage"] < 100
    return panels(layout["first"]) + panels(layout["second"])


def test_foxglove(series: set[tuple[str, str]]):
    layout = json.loads((LAYOUTS / "foxglove.json").read_text())
    assert layout.keys() >= {
        "configById",
        "globalVariables",
        "userNodes",
        "playbackConfig",
        "layout",
    }
    shown = panels(layout["layout"])
    assert sorted(shown) == sorted(layout["configById"])
    assert all(panel.partition("!")[0] == "Plot" and panel.partition("!")[2] for panel in shown)
    paths = [path for panel in layout["configById"].values() for path in panel["paths"]]
    assert all(path["enabled"] and path["timestampMethod"] == "receiveTime" for path in paths)
    named = {tuple(path["value"].rsplit(".", 1)) for path in paths}
    assert named <= series
    assert {field for _, field in named} >= SHOWN
    assert {panel["xAxisVal"] for panel in layout["configById"].values()} == {"timestamp"}


def test_plotjuggler(series: set[tuple[str, str]]):
    root = ET.parse(LAYOUTS / "plotjuggler.xml").getroot()
    assert root.tag == "root"
    splitters = root.findall("./tabbed_widget/Tab/Container/DockSplitter")
    for splitter in splitters:
        sizes = [float(size) for size in splitter.attrib["sizes"].split(";")]
        assert len(sizes) == int(splitter.attrib["count"]) == len(splitter.findall("DockArea"))
        assert sum(sizes) == pytest.approx(1.0)
    plots = root.findall("./tabbed_widget/Tab/Container/DockSplitter/DockArea/plot")
    assert len(plots) == len(root.findall(".//plot")) == 3
    named = {
        tuple(curve.attrib["name"].rsplit("/", 1))
        for plot in plots
        for curve in plot.findall("curve")
    }
    assert named <= series
    assert {field for _, field in named} >= SHOWN


def test_plotjuggler_opens_the_demo_s_run_without_a_question():
    root = ET.parse(LAYOUTS / "plotjuggler.xml").getroot()
    (file,) = root.findall("./previouslyLoaded_Datafiles/fileInfo")
    target = (LAYOUTS / file.attrib["filename"]).resolve()
    rig = LAYOUTS.parent / "clutch"
    assert target.name == "run.mcap"
    assert target.relative_to(rig / "build").parts[0] in {
        design.stem for design in (rig / "designs").glob("*.yaml")
    }
    parameters = file.find("./plugin[@ID='DataLoad MCAP']/parameters")
    assert parameters is not None  # with them the loader asks nothing
    assert parameters.attrib["selected_topics"] == "/axis"
    assert parameters.attrib["use_mcap_log_time"] in ("0", "1")
