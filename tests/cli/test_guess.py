"""`init --from` and `ingest --guess` on the files of public loggers: nothing is guessed that the
file does not tell."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from frictool.documents.bench import Bench, Layout
from frictool.documents.registry import load
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.channels.column_names import unit_in
from frictool.logs.channels.logger_presets import PRESETS
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.documentation_pages import ROOT
from tests.support.logger_headers import LOGGERS, twincat
from tests.support.recordings import Sent, json_mcap

ASKED = "?"
EXPECTED: dict[str, dict[str, tuple[str, str]]] = {
    "twincat": {
        "time": ("Time", "ms"),
        "position": ("fActPosition", ASKED),
        "effort": (ASKED, ASKED),
    },
    "siemens": {
        "time": ("Time", ASKED),
        "position": ("_DriveAxis_1.ActualPosition", ASKED),
        "effort": (ASKED, ASKED),
    },
    "odrive": {
        "time": ("time", "s"),
        "position": ("pos_estimate", "turn"),
        "velocity": ("vel_estimate", "turn/s"),
        "current": ("Iq_measured", "A"),
    },
    "odrive_counts": {
        "time": ("time", "s"),
        "position": ("pos_estimate", ASKED),
        "velocity": ("vel_estimate", ASKED),
        "current": ("Iq_measured", "A"),
    },
    "moteus": {
        "time": ("timestamp", "s"),
        "position": ("position", "turn"),
        "velocity": ("velocity", "turn/s"),
        "current": ("q_current", "A"),
    },
    "simplefoc": {
        "time": ("time", "s"),
        "position": ("Angle", "rad"),
        "velocity": ("Vel", "rad/s"),
        "current": ("Cq", "mA"),
        "voltage": ("Vq", "V"),
    },
    "vesc": {
        "time": ("ms_today", "ms"),
        "position": ("encoder_position", "deg"),
        "current": ("q_axis_current", "A"),
        "voltage": ("q_axis_voltage", "V"),
    },
    "dynamixel": {
        "time": ("time", "s"),
        "position": ("Present_Position", "count"),
        "reference": ("Goal_Position", "count"),
        "current": ("Present_Current", ASKED),
    },
    "feetech": {
        "time": ("time", "s"),
        "position": ("present_position", "count"),
        "current": ("present_current", ASKED),
    },
    "feetech_degrees": {
        "time": ("time", "s"),
        "position": ("present_position", ASKED),
        "current": ("present_current", ASKED),
    },
    "franka": {
        "time": ("time", "ms"),
        "position": (ASKED, "rad"),
        "reference": (ASKED, "rad"),
        "velocity": (ASKED, "rad/s"),
        "effort": (ASKED, "N m"),
    },
    "franka_2017": {
        "time": ("duration", "ms"),
        "position": (ASKED, "rad"),
        "reference": (ASKED, "rad"),
        "velocity": (ASKED, "rad/s"),
        "effort": (ASKED, "N m"),
    },
    "kinova": {},
    "rtde": {
        "time": ("timestamp", "s"),
        "position": (ASKED, "rad"),
        "velocity": (ASKED, "rad/s"),
        "current": (ASKED, "A"),
    },
    "rtde_repeated": {
        "time": ("timestamp", "s"),
        "position": (ASKED, "rad"),
        "reference": (ASKED, "rad"),
        "current": (ASKED, "A"),
        "current_command": (ASKED, "A"),
    },
    "rtde_poses": {"position": (ASKED, "rad")},
    "vesc_uart": {"time": ("t", ASKED), "current": (ASKED, "A")},
    "servo_rig": {
        "time": ("timestamp", "s"),
        "position": ("position", ASKED),
        "reference": ("goal_position", ASKED),
        "velocity": ("speed", ASKED),
        "voltage": (ASKED, "V"),
    },
    "servos": {
        "time": ("timestamp", "s"),
        "position": (ASKED, ASKED),
        "reference": (ASKED, ASKED),
        "velocity": (ASKED, ASKED),
    },
    "torque_sensor": {
        "time": ("time", "s"),
        "position": ("position", "rad"),
        "current": ("current", "A"),
    },
    "torque_only": {
        "time": ("time", "s"),
        "position": ("position", "rad"),
        "effort": (ASKED, "N m"),
    },
    "torque_cur": {"time": ("t", "s"), "position": ("Pos", "rad"), "current": (ASKED, ASKED)},
    "sample_index": {
        "time": ("t", ASKED),
        "position": ("angle", "deg"),
        "current": ("current", "A"),
    },
    "odrive_s1": {
        "time": ("timestamp_ms", "ms"),
        "position": ("measured_position_deg", "deg"),
        "reference": (ASKED, ASKED),
        "velocity": ("measured_velocity_deg_s", "deg/s"),
        "current": ("measured_current_A", "A"),
        "current_command": ("command_current_A", "A"),
    },
    "laas": {
        "time": ("Time", "s"),
        "position": ("Position", ASKED),
        "velocity": ("Velocity", ASKED),
        "current": ("Iq", ASKED),
    },
}


def guessed(folder: Path, text: str) -> tuple[dict[str, Any], Path]:
    log, bench = folder / "log.csv", folder / "bench.yaml"
    log.write_text(text)
    result = run("ingest", "--guess", log, "--axis", "rotary", "-o", bench, "--json")
    assert result.code == 0, result.stderr
    return json.loads(result.stdout), bench


@pytest.mark.parametrize("name", LOGGERS)
def test_what_a_logger_does_not_tell_is_asked(name: str, tmp_path: Path):
    facts, bench = guessed(tmp_path, LOGGERS[name])
    assert {channel: tuple(column) for channel, column in facts["columns"].items()} == EXPECTED[
        name
    ]
    asked = {channel for channel, column in EXPECTED[name].items() if ASKED in column}
    assert set(facts["questions"]) == asked
    if not asked:
        load(bench, Bench)
        return
    refused(
        run("ingest", tmp_path / "log.csv", "--bench", bench, "-o", tmp_path / "log.mcap"),
        3,
        "bench.yaml:",
        "could not determine from the log",
    )
    shown = run("ingest", "--guess", tmp_path / "log.csv", "--axis", "rotary", "-o", bench).stdout
    for channel in asked:
        assert f"  columns.{channel}: fill in " in shown
        (line,) = [
            line for line in bench.read_text().splitlines() if line.startswith(f"  {channel}: ")
        ]
        assert "# fill in " in line


def test_the_channels_of_twincat_keep_their_names_and_units(tmp_path: Path):
    """None of the lines about the channels passes for the header but that of the names."""
    facts, bench = guessed(tmp_path, twincat(unit="deg"))
    assert facts["columns"] == {"time": ["Time", "ms"], "position": ["fActPosition", "deg"]}
    assert "fActTorque" in facts["left"]
    assert (
        "header in line 5, units in line 19, numbers from line 23"
        in run("info", tmp_path / "log.csv", "--bench", bench).stdout
    )


def test_info_names_the_columns_of_two_drives(tmp_path: Path) -> None:
    log = tmp_path / "two.csv"
    rows = "".join(f"{k / 1000},{k},{k % 7},{-k},{k % 5}\n" for k in range(50))
    log.write_text(f"Time,pos_1,cur_1,pos_2,cur_2\n{rows}")
    refused(
        run("info", log),
        3,
        "columns.position: fill in column 'pos_1' or 'pos_2': several columns fit equally well",
    )


def test_a_column_that_two_joints_have_is_chosen_by_hand(tmp_path: Path):
    facts, bench = guessed(tmp_path, LOGGERS["rtde"])
    assert "'actual_q_0' or 'actual_q_1'" in facts["questions"]["position"]
    text = bench.read_text()
    for channel, column, unit in (
        ("position", "actual_q_1", "rad"),
        ("velocity", "actual_qd_1", "rad/s"),
        ("current", "actual_current_1", "A"),
    ):
        text = text.replace(
            f'  {channel}: {{column: "?", unit: {unit}}}',
            f"  {channel}: {{column: {column}, unit: {unit}}}",
        )
    bench.write_text(text)
    assert (
        run("ingest", tmp_path / "log.csv", "--bench", bench, "-o", tmp_path / "log.mcap").code == 0
    )


PRESET = {
    "odrive": "ODrive",
    "odrive_counts": "ODrive",
    "moteus": "moteus",
    "simplefoc": "SimpleFOC",
    "vesc": "VESC Tool",
    "dynamixel": "Dynamixel",
    "feetech": "Feetech or Dynamixel (protocol 1)",
    "feetech_degrees": "Feetech or Dynamixel (protocol 1)",
    "rtde": "Universal Robots (RTDE)",
    "rtde_repeated": "Universal Robots (RTDE)",
    "rtde_poses": "Universal Robots (RTDE)",
    "vesc_uart": "VESC (VescUart)",
    "franka": "Franka (libfranka)",
    "franka_2017": "Franka (libfranka)",
}


@pytest.mark.parametrize("name", LOGGERS)
def test_the_preset_of_a_log_is_named(name: str, tmp_path: Path) -> None:
    facts, bench = guessed(tmp_path, LOGGERS[name])
    title = PRESET.get(name)
    assert facts["preset"] == title
    shown = run("ingest", "--guess", tmp_path / "log.csv", "--axis", "rotary", "-o", bench).stdout
    assert ("with the preset" in shown) is (title is not None)
    if title is not None:
        assert f"with the preset {title}: " in shown
        assert (
            f"# Units that are missing in the log come from the preset {title}."
            in bench.read_text()
        )
        made = run("init", tmp_path / "rig", "--from", tmp_path / "log.csv")
        assert f"guessed from log.csv with the preset {title}: " in made.stdout


def test_one_value_beyond_a_turn_makes_every_unit_of_an_odrive_uncertain(tmp_path: Path) -> None:
    """A slow motion in counts has positions below 1000."""
    rows = [f"{k / 100},{400 * np.sin(k / 9):.3f},{900 * np.cos(k / 9):.3f},1" for k in range(60)]
    text = "\n".join(["time,pos_estimate,vel_estimate,Iq_measured", *rows]) + "\n"
    facts, _ = guessed(tmp_path, text)
    assert set(facts["questions"]) == {"position", "velocity"}
    assert facts["columns"]["position"] == ["pos_estimate", ASKED]


def test_a_dynamixel_with_a_load_is_no_feetech(tmp_path: Path) -> None:
    names = "time,Present_PWM,Present_Load,Present_Velocity,Present_Position,Present_Input_Voltage"
    rows = [f"{k / 100},0,0,{k % 5},{2000 + k % 90},120" for k in range(60)]
    facts, _ = guessed(tmp_path, "\n".join([names, *rows]) + "\n")
    assert facts["preset"] == "Dynamixel"
    assert facts["columns"]["position"] == ["Present_Position", "count"]


@pytest.mark.parametrize(
    "name",
    [
        "duty [%]",
        "speed [Hz]",  # of turns or of radians
        "Phase A",  # a label and no unit
        "mag_inclination_ref_deg",
        "Motor temperature [deg]",  # the unit contradicts the name
        "position sensor [V]",
        "Ori_err_norm_rad",  # an error
        "max angle [deg]",
        "inpVoltage [V]",  # a supply
        "voltage5V_v",  # a supply
        "thrust_setpoint_achieved",  # a command of another quantity
    ],
)
def test_a_column_of_another_quantity_is_no_channel(name: str, tmp_path: Path) -> None:
    rows = [f"{k / 1000},{np.sin(k / 9):.5f}" for k in range(60)]
    facts, _ = guessed(tmp_path, "\n".join([f"time [s],{name}", *rows]) + "\n")
    assert facts["columns"] == {"time": ["time", "s"]}
    assert facts["left"] == [name.partition(" [")[0]]


@pytest.mark.parametrize(
    ("header", "axis", "columns"),
    [
        (
            "Time [s],FV101.SP (%),FV101.PV (%),FV101.I (A)",
            "rotary",
            {"position": ("FV101.PV", "%"), "reference": ("FV101.SP", "%"), "current": "FV101.I"},
        ),
        (
            "Time [ms],PosSet [mm],PosAct [mm],PosLag [mm],Torque [%]",
            "linear",
            {"position": "PosAct", "reference": "PosSet", "effort": ("Torque", "%")},
        ),
        (
            "Time [s],V101.SP [mm],V101.PV [mm],V101.OP [%]",
            "linear",
            {"position": "V101.PV", "reference": "V101.SP", "voltage": (ASKED, "%")},
        ),
        (
            "Time [s],SP %,PV %,OP %,Motor Current A",
            "rotary",
            {"position": ("PV %", "%"), "reference": ("SP %", "%"), "current": "Motor Current A"},
        ),
        (
            "Time[s],EPS_SteeringAngle[deg],EPS_MotorCurrent[A],EPS_AngleRequest[deg]",
            "rotary",
            {
                "position": "EPS_SteeringAngle",
                "reference": "EPS_AngleRequest",
                "current": "EPS_MotorCurrent",
            },
        ),
        ("Time [s],stem,Motor Current [A]", "linear", {"position": ASKED, "current": ASKED}),
        (
            "Time [s],az_enc_rad,gyro_z_radps,i_q_A,az_ref_rad,el_ref_rad",
            "rotary",
            {
                "position": "az_enc_rad",
                "velocity": "gyro_z_radps",
                "current": "i_q_A",
                "reference": "az_ref_rad",
            },
        ),
    ],
)
def test_names_of_process_and_servo_controllers(
    header: str, axis: str, columns: dict[str, str | tuple[str, str]], tmp_path: Path
) -> None:
    """A set point is the reference, an actual value the position; per cent asks for the scale."""
    log, bench = tmp_path / "log.csv", tmp_path / "bench.yaml"
    count = header.count(",")
    rows = [
        ",".join(f"{v:.2f}" for v in (0.02 * k, *(9 * np.sin(k / 9 + np.arange(count)))))
        for k in range(60)
    ]
    log.write_text("\n".join([header, *rows]) + "\n")
    made = run("ingest", "--guess", log, "--axis", axis, "-o", bench, "--json")
    facts = json.loads(made.stdout)
    found = {channel: column for channel, (column, _) in facts["columns"].items()}
    expected = {
        channel: one if isinstance(one, str) else one[0] for channel, one in columns.items()
    }
    assert found == {"time": "Time", **expected}
    percent = {channel for channel, one in columns.items() if isinstance(one, tuple)}
    for channel, column in yaml.safe_load(bench.read_text())["columns"].items():
        assert (column.get("scale") == ASKED) == (channel in percent)
        assert ("fill in scale" in facts["questions"].get(channel, "")) == (channel in percent)


def test_a_repeated_column_is_offered_once(tmp_path: Path) -> None:
    facts, _ = guessed(tmp_path, LOGGERS["rtde_repeated"])
    assert facts["questions"]["current_command"] == (
        "fill in column 'target_current_0 (column 6)' or 'target_current_1 (column 7)': several "
        "columns fit equally well"
    )


def test_the_number_of_a_servo_is_no_unit(tmp_path: Path) -> None:
    facts, _ = guessed(tmp_path, LOGGERS["servos"])
    assert "column 'pos (1)' or 'pos (2)'" in facts["questions"]["position"]
    assert "column 'target pos (1)' or 'target pos (2)'" in facts["questions"]["reference"]


def test_each_preset_has_a_log() -> None:
    assert {preset.title for preset in PRESETS} == set(PRESET.values())


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("t_ms", "ms"),
        ("omega_rpm", "rpm"),
        ("rpm", "rpm"),
        ("pos", None),
        ("x", None),
        ("vel rad/s", "rad/s"),
        ("a", None),
        ("i_mA", "mA"),
    ],
)
def test_a_unit_that_ends_a_name(name: str, unit: str | None):
    assert unit_in(name) == unit


@pytest.mark.parametrize(
    "name",
    [
        "twincat",
        "odrive",
        "moteus",
        "torque_sensor",
        "torque_only",
        "torque_cur",
        "odrive_s1",
        "laas",
    ],
)
def test_info_shows_a_raw_file_in_its_own_units(name: str, tmp_path: Path):
    """Nothing is converted, and no effort is made of a current: the file does not tell the
    actuator."""
    log = tmp_path / "log.csv"
    log.write_text(LOGGERS[name])
    result = run("info", log, "--json")
    assert result.code == 0, result.stderr
    shown = {
        row["name"]: (row["column"].rpartition(" [")[0], row["unit"])
        for row in json.loads(result.stdout)["channels"]
    }
    assert shown == {
        channel: column
        for channel, column in EXPECTED[name].items()
        if channel != "time" and column[0] != ASKED
    }
    preset = f" with the preset {PRESET[name]}" if name in PRESET else ""
    assert f"guessed without --bench{preset}: " in result.stderr
    assert run("info", log).stdout.startswith("log.csv: ")


@pytest.mark.parametrize("name", ["siemens", "sample_index", "kinova", "rtde"])
def test_info_of_a_file_that_tells_too_little_asks_for_the_bench(name: str, tmp_path: Path):
    log = tmp_path / "log.csv"
    log.write_text(LOGGERS[name])
    refused(run("info", log), 3, "log.csv: ", "give --bench bench.yaml")


def test_info_counts_the_rows_without_a_number_and_says_where_they_are(tmp_path: Path) -> None:
    missing = {7: "nan", 8: "nan", 40: "inf"}
    rows = [f"{k / 1000},{missing.get(k, k % 9)},{'nan' if k == 60 else 0.5}" for k in range(80)]
    log = tmp_path / "log.csv"
    log.write_text("\n".join(["time [s],position [rad],current [A]", *rows]) + "\n")
    result = run("info", log)
    assert result.code == 0, result.stderr
    for line in (
        "lost: 2 samples from 0.006 to 0.009 s: column 'position': no finite number\n",
        "lost: 1 sample from 0.039 to 0.041 s: column 'position': no finite number\n",
        "lost: 1 sample from 0.059 to 0.061 s: column 'current': no finite number\n",
    ):
        assert line in result.stdout, result.stdout
    assert (
        sum(loss["samples"] for loss in json.loads(run("info", log, "--json").stdout)["lost"]) == 4
    )


def sampled(header: str, row: str, count: int = 60) -> str:
    """A log whose rows are `row`, formatted with the index `k` and a position `x`."""
    rows = [row.format(k=k, x=f"{90 * np.sin(k / 9):.5f}") for k in range(count)]
    return "\n".join([header, *rows]) + "\n"


AMBIGUOUS = sampled("Time,angle [deg]", "03/04/2026 12:00:00.{k:03d},{x}")


@pytest.mark.parametrize(
    ("order", "day"), [("day-first", "2026-04-03"), ("month-first", "2026-03-04")]
)
def test_dates_that_begin_with_the_day_or_the_month_are_decided_by_an_option(
    order: str, day: str, tmp_path: Path
) -> None:
    log, bench = tmp_path / "log.csv", tmp_path / "bench.yaml"
    log.write_text(AMBIGUOUS)
    refused(
        run("ingest", "--guess", log, "-o", bench),
        3,
        "may begin with the day or with the month",
        "use --layout dates=day-first or month-first",
    )
    option = ("--layout", f"dates={order}")
    made = run("ingest", "--guess", log, *option, "-o", bench)
    assert made.code == 0, made.stderr
    assert load(bench, Bench).layout == Layout(dates=order)
    assert run("init", tmp_path / "rig", "--from", log, *option).code == 0
    assert load(tmp_path / "rig/bench.yaml", Bench).layout == Layout(dates=order)
    assert run("info", log, *option).code == 0
    done = run("ingest", log, "--bench", bench, "-o", tmp_path / "log.mcap")
    assert done.code == 0, done.stderr
    epoch = int(read_mcap(tmp_path / "log.mcap").metadata["time"]["epoch_ns"])
    assert np.datetime64(epoch, "ns") == np.datetime64(f"{day}T12:00:00")


@pytest.mark.parametrize(
    ("text", "option"),
    [
        (AMBIGUOUS, "dates=day-first"),
        (AMBIGUOUS.replace("03/04", "31/03").rstrip("\n"), "whole=true"),
        ("x\n" * 300, "first_line=VALUE"),
    ],
)
def test_a_refusal_that_names_a_key_of_the_bench_names_the_option(
    text: str, option: str, tmp_path: Path
) -> None:
    log = tmp_path / "log.csv"
    log.write_text(text)
    for call in (
        ("ingest", "--guess", log, "-o", tmp_path / "bench.yaml"),
        ("init", tmp_path / "rig", "--from", log),
        ("info", log),
    ):
        refused(run(*call), 3, f" --layout {option}")
    bench = tmp_path / "known.yaml"
    bench.write_text((ROOT / "configs/clutch/bench.yaml").read_text())
    assert "--layout" not in run("info", log, "--bench", bench).stderr


def test_a_clock_with_a_blank_in_its_name_is_quoted(tmp_path: Path) -> None:
    """The stamps of the recording are no times; its log times are."""
    rows = [
        Sent(
            "/rig",
            "rig.Motor",
            "",
            k * 10**7,
            {"timestamp": {"sec": 10**10, "nsec": k}, "position": 1.0 * k, "current": 0.1 * k},
        )
        for k in range(1, 200)
    ]
    log, bench = tmp_path / "log.mcap", tmp_path / "bench.yaml"
    log.write_bytes(json_mcap(rows))
    refused(run("info", log), 3, "a message has no timestamp; use --layout 'clock=log time'")
    done = run("info", log, "--layout", "clock=log time", "--json")
    assert json.loads(done.stdout)["duration_s"] == pytest.approx(1.98)
    text = (ROOT / "configs/clutch/bench.yaml").read_text()
    text = text.replace("column: encoder", "column: /rig.position")
    bench.write_text(text.replace("column: current", "column: /rig.current"))
    refused(run("info", log, "--bench", bench), 3, "write layout.clock: 'log time' in bench.yaml")


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("dates=x", "--layout dates: found 'x'; allowed: day-first | month-first"),
        ("date=x", "--layout date: unknown key, did you mean 'dates'?"),
        ("dates", "--layout: found 'dates'; allowed: KEY=VALUE"),
        ("dates=[", "--layout not valid YAML"),
        ("start_s=1", "--layout start_s needs period_s"),
    ],
)
def test_a_wrong_layout_is_refused(value: str, message: str, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text(AMBIGUOUS)
    result = run("info", log, "--layout", value)
    assert result.code == 2
    assert f"Error: {message}" in result.stderr


def test_a_layout_that_would_be_ignored_is_refused(tmp_path: Path) -> None:
    log, option = tmp_path / "log.csv", ("--layout", "dates=day-first")
    log.write_text(AMBIGUOUS)
    for call, message in (
        (("ingest", log, "-o", tmp_path / "x.mcap"), "--layout belongs to --guess"),
        (("init", tmp_path / "rig"), "--layout belongs to --from LOG"),
        (("info", log, "--bench", log), "--layout does not work with --bench"),
    ):
        result = run(*call, *option)
        assert result.code == 2
        assert f"Error: {message}" in result.stderr


def test_a_year_of_two_digits_is_named(tmp_path: Path) -> None:
    facts, bench = guessed(tmp_path, sampled("Time,angle [deg]", "31/01/26 12:00:00.{k:03d},{x}"))
    assert facts["columns"] == {"position": ["angle", "deg"]}
    assert facts["left"] == ["Time"]
    reason = facts["unreadable"]["Time"]
    assert reason.startswith("line 2: column 'Time': found '31/01/26 12:00:00.000'; allowed: ")
    assert reason.endswith("with four digits of the year")
    assert f"# cannot be read: {reason}" in bench.read_text()
    shown = run("ingest", "--guess", tmp_path / "log.csv", "-o", bench).stdout
    assert "cannot be read and left out: 'Time': line 2: found '31/01/26 12:00:00.000'; " in shown


@pytest.mark.parametrize("column", range(2, 14))
def test_a_damaged_cell_does_not_select_another_joint(column: int, tmp_path: Path) -> None:
    header, *rows = LOGGERS["franka"].splitlines()
    expected = guessed(tmp_path, LOGGERS["franka"])[0]["columns"]
    cells = rows[20].split(",")
    rows[20] = ",".join([*cells[:column], "0.16q5", *cells[column + 1 :]])
    made = guessed(tmp_path, "\n".join([header, *rows]) + "\n")[0]
    assert made["columns"] == expected


def test_an_empty_cell_in_a_column_that_is_not_used_is_left_out(tmp_path: Path) -> None:
    text = sampled("time [s],angle [deg],humidity,mode", "{k}e-3,{x},40,IDLE")
    facts, bench = guessed(tmp_path, text.replace("40,IDLE", ",IDLE", 31))
    assert facts["columns"] == {"time": ["time", "s"], "position": ["angle", "deg"]}
    assert facts["left"] == ["humidity", "mode"]
    assert facts["unreadable"] == {
        "humidity": "line 2: column 'humidity': found an empty cell; allowed: a number",
        "mode": "line 2: column 'mode': found 'IDLE'; allowed: a number",
    }
    done = run("ingest", tmp_path / "log.csv", "--bench", bench, "-o", tmp_path / "log.mcap")
    assert done.code == 0, done.stderr


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (
            "0.03,,40",
            "log.csv:32: column 'angle': found an empty cell; allowed: a number; the guess needs",
        ),
        ("0.03,1", "log.csv:32: has 2 cells, but the header in line 1 has 3"),
    ],
)
def test_damage_of_a_used_column_or_of_a_row_is_refused(
    row: str, message: str, tmp_path: Path
) -> None:
    lines = sampled("time [s],angle [deg],humidity", "{k}e-3,{x},40").splitlines()
    lines[31] = row
    log = tmp_path / "log.csv"
    log.write_text("\n".join(lines) + "\n")
    refused(run("ingest", "--guess", log, "-o", tmp_path / "bench.yaml"), 3, message)
