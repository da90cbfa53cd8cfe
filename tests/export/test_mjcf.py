"""`export --lang mjcf`: MuJoCo moves under the file as the model says."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from frictool.adapters.axis_model import load_of
from frictool.documents.bench import Bench
from frictool.documents.laws import Laws, Load, Ripple
from frictool.documents.model import Model
from frictool.documents.presliding import Contact, Presliding
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.export.export_origin import ExportOrigin
from frictool.export.mjcf import mjcf_files
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.documentation_pages import ROOT
from tests.support.export_models import BENCH, estimate, known_effort, known_model

GOLDEN = Path(__file__).parent / "golden"
ORIGIN = ExportOrigin("0" * 64, "frictool export")
KNOWN = {"armature": 2.5e-3, "damping": 0.008, "frictionloss": 0.25}


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("known") / "bench.yaml"
    path.write_text(BENCH)
    return path


@pytest.fixture(scope="module")
def plain(bench: Path) -> Model:
    """Linear and Coulomb friction, with an offset."""
    return known_model(load(bench, Bench))


@pytest.fixture(scope="module")
def lugre(plain: Model) -> Model:
    """LuGre friction with the Stribeck effect, ripple and spring."""
    contact = Contact(estimate(300.0, "N m/rad", 30.0), estimate(1.7, "N m s/rad", 0.1), 0.01, 0.01)
    presliding = Presliding(
        "lugre",
        estimate(1e-3, "rad"),
        estimate(300.0, "N m/rad"),
        estimate(0.4, "N m"),
        lugre=contact,
    )
    ripple = Ripple(
        3.0,
        Quantity(1.7, unit="rad"),  # type: ignore[arg-type]
        estimate(0.03, "N m", 0.01),
        estimate(-0.04, "N m", 0.01),
    )
    parameters = replace(
        plain.parameters,
        breakaway=estimate(0.4, "N m", 0.02),
        stribeck_velocity=estimate(0.5, "rad/s", 0.1),
        offset=estimate(0.0, "N m"),
    )
    return replace(
        plain,
        law="stribeck",
        parameters=parameters,
        presliding=presliding,
        laws=Laws(load=Load(stiffness=estimate(0.2, "N m/rad"), ripple=ripple)),
    )


@pytest.fixture(scope="module")
def mujoco() -> Any:
    return pytest.importorskip("mujoco", reason="mujoco is not installed")


def text_of(model: Model) -> str:
    text = mjcf_files(model, ORIGIN, ())[0]["known.xml"]
    assert isinstance(text, str)
    return text


def test_files_are_those_of_the_folder(plain: Model, lugre: Model) -> None:
    for name, model in (("plain", plain), ("lugre", lugre)):
        files, _ = mjcf_files(model, ORIGIN, ())
        assert files["known.xml"] == (GOLDEN / f"{name}.xml").read_text()
        assert files["known_ranges.json"] == (GOLDEN / f"{name}_ranges.json").read_text()


def test_each_range_names_a_number_of_the_model_in_memory(
    mujoco: Any, plain: Model, lugre: Model
) -> None:
    for model in (plain, lugre):
        files, _ = mjcf_files(model, ORIGIN, ())
        read = mujoco.MjModel.from_xml_string(files["known.xml"])
        for row in json.loads(files["known_ranges.json"])["attributes"]:  # type: ignore[arg-type]
            name, _, index = row["mjModel"].partition(".")
            values = getattr(read, name)
            if name.startswith("actuator"):
                values = values[0 if row["element"] == "general" else 1]
                value = values[int(index)]
            else:
                value = values[0]
            assert value == pytest.approx(row["value"], rel=1e-15), row
            assert row["low"] <= row["value"] <= row["high"]


def test_offset_spring_and_ripple_oppose_a_positive_drive(
    mujoco: Any, plain: Model, lugre: Model
) -> None:
    for model in (plain, lugre):
        read = mujoco.MjModel.from_xml_string(text_of(model))
        data = mujoco.MjData(read)
        for position in np.linspace(-2.0, 2.0, 9):
            data.qpos[0] = position
            data.ctrl[0] = 3.0
            mujoco.mj_forward(read, data)
            effort = data.qfrc_actuator[0] + data.qfrc_passive[0]
            load = load_of(model).at(np.array([position]))[0]
            wanted = 0.1 * 3.0 - load - model.parameters.offset.value
            assert effort == pytest.approx(wanted, abs=1e-9)


def test_lugre_friction_is_that_of_the_model_in_steady_slip(mujoco: Any, lugre: Model) -> None:
    model = replace(lugre, laws=None)
    read = mujoco.MjModel.from_xml_string(text_of(model))
    for speed in (0.1, 0.5, 1.0, 3.0):
        data = mujoco.MjData(read)
        for _ in range(int(0.2 / read.opt.timestep)):
            data.qvel[0] = speed
            mujoco.mj_step(read, data)
        data.qvel[0] = speed
        mujoco.mj_forward(read, data)
        friction = -data.qfrc_actuator[0] - data.qfrc_passive[0]
        wanted = 0.25 + 0.15 * math.exp(-((speed / 0.5) ** 2)) + 0.008 * speed
        assert friction == pytest.approx(wanted, rel=1e-3)


def test_refuses_what_mjcf_cannot_represent(lugre: Model, plain: Model, tmp_path: Path) -> None:
    nonlinear = ROOT / "configs/clutch/nonlinear.yaml"
    refused(
        run("export", nonlinear, "--lang", "mjcf", "-o", tmp_path / "out"),
        4,
        "MJCF cannot represent backward",
        "position (position-dependent friction)",
        "--without position",
    )
    with pytest.raises(NoSolutionError, match="stribeck"):
        mjcf_files(replace(lugre, presliding=None), ORIGIN, ())
    assert lugre.laws is not None
    assert lugre.laws.load is not None
    ripple = lugre.laws.load.ripple
    assert ripple is not None
    load = replace(lugre.laws.load, harmonics=(replace(ripple, cycles=2.0 * ripple.cycles),))
    rich = replace(lugre, laws=replace(lugre.laws, load=load))
    with pytest.raises(NoSolutionError, match="cannot represent harmonics"):
        mjcf_files(rich, ORIGIN, ())
    assert (
        "left out: harmonics (further harmonics of the effort ripple)"
        in (mjcf_files(rich, ORIGIN, {"harmonics"})[1])
    )
    with pytest.raises(NoSolutionError, match=r"stribeck_exponent 1; allowed: 2"):
        mjcf_files(replace(lugre, laws=Laws(stribeck_exponent=1.0)), ORIGIN, ())
    _, notes = mjcf_files(lugre, ORIGIN, {"presliding", "stribeck", "ripple", "spring"})
    assert "left out: breakaway 0.4 N m (Coulomb friction 0.25 N m)" in notes
    assert "no interval in the model: offset" not in mjcf_files(plain, ORIGIN, ())[1]


@pytest.fixture(scope="module")
def log(mujoco: Any, plain: Model, bench: Path) -> Path:
    """A log of MuJoCo with known parameters."""
    text = text_of(replace(plain, parameters=replace(plain.parameters, offset=estimate(0, "N m"))))
    read = mujoco.MjModel.from_xml_string(text)
    for name, value in KNOWN.items():
        assert getattr(read, f"dof_{name}")[0] == value
    read.opt.timestep = 5e-5  # MuJoCo integrates with order 1
    data = mujoco.MjData(read)
    time = np.arange(8000) * 1e-3
    current = known_effort(time) / 0.1
    rows = ["time,position,current"]
    for at, drive in zip(time, current, strict=True):
        position = round(data.qpos[0] / 1e-5) * 1e-5
        rows.append(f"{at:.3f},{position:.5f},{drive:.9f}")
        data.ctrl[0] = drive
        mujoco.mj_step(read, data, nstep=20)
    path = bench.parent / "log.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


def test_round_trip_through_a_log_of_mujoco(
    mujoco: Any, log: Path, bench: Path, tmp_path: Path
) -> None:
    """Identified from the log and played along its motion: the torque is in the intervals."""
    model = tmp_path / "model.yaml"
    done = run("identify", log, "--bench", bench, "-o", model)
    assert done.code in (0, 1), done.stderr  # 1: the log does not show the breakaway
    call: list[Any] = ["export", model, "--lang", "mjcf", "-o", tmp_path / "out"]
    result = run(*call, "--check", log, "--json")
    assert result.code == 0, result.stderr
    ranges = json.loads((tmp_path / "out/known_ranges.json").read_text())["attributes"]
    interval = {row["attribute"]: (row["low"], row["value"], row["high"]) for row in ranges}
    for name, value in KNOWN.items():
        assert interval[name][0] <= value <= interval[name][2], (name, interval[name])
        assert interval[name][1] == pytest.approx(value, rel=0.05)
    read = mujoco.MjModel.from_xml_path(str(tmp_path / "out/known.xml"))
    data = mujoco.MjData(read)
    rng = np.random.default_rng(20261123)
    for speed, acceleration in rng.uniform([-30.0, -200.0], [30.0, 200.0], (50, 2)):
        if abs(speed) < 1.0:
            continue
        data.qvel[0], data.qacc[0] = speed, acceleration
        mujoco.mj_inverse(read, data)
        regressor = {"armature": acceleration, "damping": speed, "frictionloss": np.sign(speed)}
        known = sum(KNOWN[name] * factor for name, factor in regressor.items())
        widths = [(interval[name][0], interval[name][2]) for name in regressor]
        low, high = (
            sum(
                sorted((ends[0] * factor, ends[1] * factor))[end]
                for ends, factor in zip(widths, regressor.values(), strict=True)
            )
            for end in (0, 1)
        )
        assert low <= known <= high
        # the regularised friction is below frictionloss by a share of 1e-4
        assert low - 1e-4 <= data.qfrc_inverse[0] <= high + 1e-4
    check = json.loads(result.stdout)["check"]
    assert check["samples"] == 8000
    assert check["difference_rms"] < 0.02 * check["measured_rms"]["frictool"] + 0.05


def test_check_reports_creep_below_breakaway(
    mujoco: Any, log: Path, plain: Model, tmp_path: Path
) -> None:
    path = tmp_path / "model.yaml"
    path.write_text(to_yaml(replace(plain, name="known")))
    quiet = tmp_path / "quiet.csv"
    quiet.write_text(
        "time,position,current\n"
        + "".join(f"{k * 1e-3:.3f},{1e-5 * (k % 2):.5f},{2.0:.1f}\n" for k in range(2000))
    )
    result = run(
        "export", path, "--lang", "mjcf", "--check", quiet, "-o", tmp_path / "out", "--json"
    )
    assert result.code == 0, result.stderr
    check = json.loads(result.stdout)["check"]
    assert check["rest_s"] == pytest.approx(1.999)
    assert 0.0 < check["creep"] < 1e-4
    assert check["creep"] == pytest.approx(check["difference_largest"], rel=1e-6)
    assert 0.0 < check["hold_speed"] < 1e-3
    softer = (tmp_path / "out/known.xml").read_text().replace("0.9999 0.9999", "0.9 0.95")
    target = mujoco.MjModel.from_xml_string(softer)
    data = mujoco.MjData(target)
    for _ in range(1000):
        data.qfrc_applied[0] = 0.5 * 0.25 + 0.05
        mujoco.mj_step(target, data)
    assert data.qvel[0] > 100.0 * check["hold_speed"]


def test_a_linear_axis_creeps_as_little_as_mujoco_allows(mujoco: Any) -> None:
    """At half of the Coulomb friction, the reference acceleration -b v equals R times the force."""
    model = load(ROOT / "configs/mass/model.yaml", Model)
    text, _ = mjcf_files(model, ORIGIN, ())[0].values()
    read = mujoco.MjModel.from_xml_string(text)
    inertia, force = model.parameters.inertia.value, 0.5 * model.parameters.coulomb.value
    assert read.dof_invweight0[0] == pytest.approx(1.0 / inertia, rel=1e-5)
    data = mujoco.MjData(read)
    for _ in range(2000):
        data.qfrc_applied[0] = force
        mujoco.mj_step(read, data)
    impedance = 0.9999
    regularisation = (1.0 - impedance) / impedance / inertia
    damping = 2.0 / (impedance * 2.0 * read.opt.timestep)
    assert data.qvel[0] == pytest.approx(regularisation * force / damping, rel=1e-3)


def test_check_without_mujoco_says_what_to_install(
    plain: Model, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "mujoco", None)
    path = tmp_path / "model.yaml"
    path.write_text(to_yaml(plain))
    refused(
        run("export", path, "--lang", "mjcf", "--check", log, "-o", tmp_path / "out"),
        3,
        "pip install 'frictool[mujoco]'",
    )
