"""A key of a design that its method does not use is an error."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.documents import controller, design_blocks
from frictool.documents.design import Design
from frictool.documents.registry import load
from frictool.documents.synthesis_methods import METHODS, READ_BY
from frictool.errors import DocumentError

ROOT = Path(__file__).parents[2] / "configs"
BASE = "format: design/1\nname: a\naxis: rotary\nstructure: position\nweights: {}\n"
ASKED = {
    "schedule": "schedule: [inertia]",
    "vertices": "vertices: first_order",
    "frozen_at": "frozen_at: identified",
    "scheduled": "scheduled: true",
    "grid": "grid: {degree: 1}",
    "channel_effort": "channel_effort: 0.003",
    "poles": "poles: {decay_rad_s: 3}",
    "pole_bound_rad_s": "pole_bound_rad_s: 1000",
    "recentring": "recentring: 1.05",
    "ease": "ease: 2",
    "domain": "domain: continuous",
    "order": "order: 3",
    "integrator": "integrator: true",
    "relax": "relax: auto",
    "pid": "pid: {gain: {value: 1, unit: N m/rad}}",
}
CASCADE = BASE.replace("structure: position", "structure: speed_cascade") + "method: lpv\n"
LAW = "action: cut, formula: sqrt(F/J)"
FILTER = "prefilter: {natural_frequency_rad_s: 30, damping: 0.8}"


def _design(folder: Path, *lines: str) -> Design:
    path = folder / "design.yaml"
    path.write_text(BASE + "\n".join(lines) + "\n")
    return load(path, Design)


@pytest.mark.parametrize("key", READ_BY)
@pytest.mark.parametrize("method", METHODS)
def test_a_key_that_the_method_does_not_read_is_refused(
    tmp_path: Path, key: str, method: str
) -> None:
    lines = [f"method: {method}", ASKED[key]]
    if method == "pid" and key != "pid":
        lines.append(ASKED["pid"])
    if method in READ_BY[key]:
        assert _design(tmp_path, *lines).method == method
    else:
        with pytest.raises(
            DocumentError,
            match=rf"{key} belongs to methods? .*, not to method {method}; remove the key",
        ):
            _design(tmp_path, *lines)


def test_the_trade_reads_the_schedule_of_its_inequalities(tmp_path: Path) -> None:
    assert _design(
        tmp_path, "method: minimax", "relax: auto", ASKED["schedule"], ASKED["recentring"]
    ).schedule == ("inertia",)
    with pytest.raises(DocumentError, match="poles belongs to methods"):
        _design(tmp_path, "method: minimax", "relax: auto", ASKED["poles"])


def test_a_schedule_of_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DocumentError, match="schedule: found a list of 0; allowed: 1 to 5"):
        _design(tmp_path, "method: lpv", "schedule: []")


def test_the_rigs_ask_for_nothing_in_vain() -> None:
    paths = [*ROOT.glob("*/designs/*.yaml"), *ROOT.glob("*/refused/*.yaml")]
    assert len(paths) > 6
    for path in paths:
        load(path, Design)


CONTRADICTIONS = {
    "position_law.gain_per_s": (
        ["position_law: {action: cut, formula: sqrt(F/J), gain_per_s: 1}"],
        "`kind: proportional` needs gain_per_s",
    ),
    "no formula": (["position_law: {action: cut}"], "`kind: square_root` needs `formula`"),
    "a formula too much": (
        ["position_law: {action: none, kind: proportional, formula: sqrt(F/J)}"],
        "`kind: proportional` needs no formula",
    ),
    "virtual friction of a proportional law": (
        [
            "position_law: {action: none, kind: proportional, gain_per_s: 1, "
            "virtual_coulomb_factor: 2}"
        ],
        "virtual_coulomb_factor belongs to `kind: square_root`",
    ),
    "band of a proportional law": (
        [
            "position_law: {action: none, kind: proportional, gain_per_s: 1, band: {value: 1, "
            "unit: rad}}"
        ],
        "`band` belongs to `kind: square_root`, `action: cut` or `action: brake`",
    ),
    "rest_speed": (
        [f"position_law: {{{LAW}, rest_speed: {{value: 1, unit: rad/s}}}}"],
        "`action: brake` needs rest_speed; with any other",
    ),
    "brake without": (
        ["position_law: {action: brake, formula: sqrt(F/J)}"],
        "`action: brake` needs rest_speed",
    ),
    "settled_speed of none": (
        [
            "position_law: {action: none, formula: sqrt(F/J), settled_speed: {value: 1, unit: "
            "rad/s}}"
        ],
        "settled_speed belongs to `action: cut` or `action: brake`",
    ),
    "settled_speed without prefilter": (
        [f"position_law: {{{LAW}, settled_speed: {{value: 1, unit: rad/s}}}}"],
        "position_law.settled_speed needs a filtered reference, but there is no `prefilter`",
    ),
    "prefilter without settled_speed": (
        [f"position_law: {{{LAW}}}", FILTER],
        "settled_speed: missing; action cut waits until",
    ),
    "limiter": (
        [f"position_law: {{{LAW}}}", "limiter: {condition: error}"],
        "`limiter` belongs to `structure: position`",
    ),
    "measured and filtered": (
        ["velocity: {source: measured, filter_rad_s: 100}"],
        "a measured speed has no filter",
    ),
    "order of no filter": (["velocity: {order: 1, filter_rad_s: 0}"], "remove `order`"),
    "virtual speed": (
        ["limiter: {condition: error, virtual_speed: {value: 1, unit: rad/s}}"],
        "virtual_speed needs virtual_coulomb",
    ),
    "observer": (
        ["friction_compensation: {source: observer}"],
        "`source: observer` needs observer_rad_s",
    ),
    "observer's velocity": (
        ["friction_compensation: {source: observer, observer_rad_s: 10, velocity: measured}"],
        "`velocity` and smoothing_speed belong to `source: model`",
    ),
    "reference": (
        ["friction_compensation: {source: model, velocity: reference}"],
        "`velocity: reference` needs smoothing_speed",
    ),
    "no reference": (
        [
            f"position_law: {{{LAW}}}",
            "friction_compensation: {source: model, velocity: reference, smoothing_speed: {value: "
            "1, unit: rad/s}}",
        ],
        "the speed of the filtered reference; add `prefilter`",
    ),
    "both gains": (
        ["pid: {gain: {value: 1, unit: N m/rad}, speed_gain: {value: 1, unit: N m s/rad}}"],
        "give `gain` for a position loop, or `speed_gain`",
    ),
    "derivative": (
        ["pid: {gain: {value: 1, unit: N m/rad}, derivative_time_s: 1}"],
        "derivative_time_s and filter_ratio go together",
    ),
    "derivative of a speed": (
        ["pid: {speed_gain: {value: 1, unit: N m s/rad}, derivative_time_s: 1, filter_ratio: 10}"],
        "the speed loop is a PI",
    ),
    "sections that are scheduled": (
        [f"position_law: {{{LAW}}}", "form: sos", "scheduled: true"],
        "`form: sos` cannot be combined with `scheduled`",
    ),
}


@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_what_contradicts_itself_is_refused(tmp_path: Path, name: str) -> None:
    lines, message = CONTRADICTIONS[name]
    path = tmp_path / "design.yaml"
    path.write_text(CASCADE + "\n".join(lines) + "\n")
    with pytest.raises(DocumentError, match=message):
        load(path, Design)


def test_a_pid_has_the_gain_of_its_structure(tmp_path: Path) -> None:
    speed = "pid: {speed_gain: {value: 1, unit: N m s/rad}, integral_time_s: 1}"
    with pytest.raises(DocumentError, match="`structure: position` takes `gain`"):
        _design(tmp_path, "method: pid", speed)
    with pytest.raises(DocumentError, match="`method: pid` needs the key `pid`"):
        _design(tmp_path, "method: pid")
    path = tmp_path / "cascade.yaml"
    path.write_text(
        CASCADE.replace("lpv", "pid").replace("weights: {}", "weights: {drive: 1}")
        + f"{speed}\nposition_law: {{{LAW}}}\n"
    )
    with pytest.raises(DocumentError, match="without weights; write weights"):
        load(path, Design)


def test_what_reads_a_speed_is_known(tmp_path: Path) -> None:
    lines = {
        "limiter: {condition: error}": False,
        "limiter: {condition: energy}": True,
        "limiter: {condition: error, virtual_coulomb: {value: 1, unit: N m}}": True,
        "friction_compensation: {source: observer, observer_rad_s: 10}": True,
        "friction_compensation: {source: model}": True,
    }
    assert {line: _design(tmp_path, "method: lpv", line).reads_speed for line in lines} == lines


def test_sections_have_no_integrator_that_a_limiter_could_hold(tmp_path: Path) -> None:
    with pytest.raises(DocumentError, match="`form: sos` cannot be combined with `limiter`"):
        _design(tmp_path, "method: lpv", "limiter: {condition: error}", "form: sos")


def test_a_prefilter_beyond_the_range_of_numbers_is_refused_in_design_and_controller() -> None:
    for kind in (design_blocks.PrefilterDesign, controller.Prefilter):
        kind(30.0, 0.8)
        for frequency, damping in ((30.0, 1e308), (1e200, 0.8)):
            with pytest.raises(ValueError, match="too large to be sampled"):
                kind(frequency, damping)
