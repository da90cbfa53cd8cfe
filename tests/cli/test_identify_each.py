"""`frictool identify --each`: many logs to a model each, the same as alone, and wherever it is
made; what is bad is a row."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
import pickle
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from frictool.documents.provenance import Input, digest
from frictool.documents.writing import to_yaml
from frictool.errors import LogError
from frictool.identify.batch import IdentifyJob, groups
from frictool.identify.batch_table import COLUMNS
from frictool.identify.methods import IdentificationRequest
from frictool.logs.fleet import FleetLog, members
from frictool.logs.origin import LogName
from studies.command_line import CommandResult, run
from studies.rigs.identification_rigs import CLUTCH, clutch
from tests.support.command_line import refused
from tests.support.short_logs import first_lines

PARTS = (("U1", "2026-01-03", 1.0), ("U1", "2026-02-03", 1.0), ("U2", "2026-01-04", 1.3))
DATE = r"\d{4}-\d\d-\d\d"


def part(number: int, scale: float) -> str:
    """A third of the first 9 s of the sample log, its current scaled: of another friction and
    another inertia."""
    lines = first_lines("sines.csv", 9000)
    head = [line for line in lines if not line[0].isdigit()]
    rows = [line.rsplit(",", 1) for line in lines[len(head) :]]
    third = rows[number * len(rows) // 3 : (number + 1) * len(rows) // 3]
    return (
        "\n".join([*head, *(f"{others},{float(current) * scale!r}" for others, current in third)])
        + "\n"
    )


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """Two logs of one unit, one of another, one of a third that is no log."""
    root = tmp_path_factory.mktemp("fleet")
    folder = root / "logs"
    for number, (unit, date, scale) in enumerate(PARTS):
        (folder / unit).mkdir(parents=True, exist_ok=True)
        (folder / unit / f"{date}.csv").write_text(part(number, scale))
    (folder / "U3").mkdir()
    (folder / "U3" / "2026-01-05.csv").write_text("time,encoder,current\n0,1,2\n")
    return SimpleNamespace(root=root, folder=folder, first=folder / "U1" / "2026-01-03.csv")


def each(*arguments: str | Path) -> CommandResult:
    return run("identify", "--each", *arguments, "--bench", CLUTCH)


def table(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


@pytest.fixture(scope="module")
def made(fleet: SimpleNamespace) -> SimpleNamespace:
    """The models of each log, and what was told."""
    target = fleet.root / "models"
    result = each("log", fleet.folder, "--date", DATE, "--cores", "1", "-o", target)
    assert result.code == 3, result.stderr
    return SimpleNamespace(
        folder=target, told=result.stdout, rows=table((target / "parameters.csv").read_text())
    )


def test_each_log_gives_the_model_that_it_gives_alone(
    fleet: SimpleNamespace, made: SimpleNamespace, tmp_path: Path
) -> None:
    alone = tmp_path / "alone.yaml"
    assert run("identify", fleet.first, "--bench", CLUTCH, "-o", alone).code == 0
    assert (made.folder / "U1" / "2026-01-03.yaml").read_bytes() == alone.read_bytes()
    assert [(row["unit"], row["date"], row["file"]) for row in made.rows] == [
        *((unit, date, f"{unit}/{date}.csv") for unit, date, _ in PARTS),
        ("U3", "2026-01-05", "U3/2026-01-05.csv"),
    ]
    for row in made.rows[:3]:
        assert (made.folder / row["model"]).is_file()
        assert float(row["coulomb_low"]) < float(row["coulomb"]) < float(row["coulomb_high"])
        assert (
            row["breakaway"] == ""
        )  # no ramps: the bench's interval in the model is nothing that the log has given
    assert made.rows[3]["model"] == ""
    assert made.rows[3]["reason"] == "has 1 row; allowed: at least 2"
    assert not (made.folder / "U3").exists()
    assert "3 models of 3 units, 1 could not be made" in made.told
    coulomb = next(line for line in made.told.splitlines() if line.startswith("coulomb"))
    assert "no: units differ by" in coulomb
    assert "logs of one unit" not in coulomb


def test_what_travels_to_another_process_gives_the_same_model(
    fleet: SimpleNamespace, made: SimpleNamespace
) -> None:
    """`python -m tests.accept build/accept.json cluster.commands` runs the command on a cluster."""
    text = (made.folder / "U1" / "2026-01-03.yaml").read_text()
    (group,) = groups(members([fleet.first]), "log")
    group = replace(
        group,
        words=next(line for line in text.splitlines() if "command:" in line).partition(": ")[2],
    )
    work = IdentifyJob(
        to_yaml(clutch()), Input(CLUTCH.name, digest(CLUTCH)), IdentificationRequest()
    )
    there = pickle.loads(pickle.dumps(work))
    back = pickle.loads(pickle.dumps(there((fleet.first,), pickle.loads(pickle.dumps(group)))))
    assert back.model.text == text


def test_what_an_earlier_run_wrote_into_the_folder_is_no_log(
    fleet: SimpleNamespace, tmp_path: Path
) -> None:
    (tmp_path / "models").mkdir()
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_bytes(fleet.first.read_bytes())
    (tmp_path / "models" / "parameters.csv").write_text("unit,date,file\n")
    result = each("log", tmp_path, "-o", tmp_path / "models")
    assert result.code == 0
    assert [row["file"] for row in table((tmp_path / "models" / "parameters.csv").read_text())] == [
        "a.csv",
        "b.csv",
    ]
    assert "b.csv: warning: gives the same numbers as a.csv" in result.stdout


def test_a_log_is_never_taken_for_an_earlier_table_and_overwritten(
    fleet: SimpleNamespace, tmp_path: Path
) -> None:
    """A table is told from a log by what is in it: -o may be any name in the folder of the logs."""
    (tmp_path / "a.csv").write_bytes(fleet.first.read_bytes())
    refused(
        each("log", tmp_path, "-o", tmp_path / "a.csv"),
        3,
        "a.csv: is an input of this command and would be overwritten",
    )
    assert (tmp_path / "a.csv").read_bytes() == fleet.first.read_bytes()


def test_the_tables_of_earlier_runs_are_no_logs_whatever_they_are_called(
    fleet: SimpleNamespace, made: SimpleNamespace, tmp_path: Path
) -> None:
    (tmp_path / "a.csv").write_bytes(fleet.first.read_bytes())
    (tmp_path / "fleet.csv").write_bytes(made.folder.joinpath("parameters.csv").read_bytes())
    if importlib.util.find_spec("pyarrow"):
        each("log", fleet.first, "-o", tmp_path / "fleet.parquet")
        run("convert", fleet.first, "--bench", CLUTCH, "-o", tmp_path / "log.parquet")
    kept = {"a.csv", "log.parquet"} & {path.name for path in tmp_path.iterdir()}
    assert {member.name.file for member in members([tmp_path])} == kept
    with pytest.raises(LogError, match=r"is a table of results, or contains only such tables"):
        members([tmp_path / "fleet.csv"])


def test_nothing_found_is_told_before_nothing_read_and_a_pattern_that_finds_nothing(
    fleet: SimpleNamespace, tmp_path: Path
) -> None:
    lines = fleet.first.read_text().splitlines()
    moved = next(number for number, line in enumerate(lines) if line[0].isdigit())
    still = [",".join([line.split(",")[0], *["0"] * line.count(",")]) for line in lines[moved:]]
    (tmp_path / "still.csv").write_text("\n".join([*lines[:moved], *still]) + "\n")
    result = each("log", tmp_path / "still.csv", fleet.folder / "U3", "--date", "x+", "--json")
    assert result.code == 1
    assert {one["file"]: one["read"] for one in json.loads(result.stdout)["models"]} == {
        (tmp_path / "still.csv").as_posix(): True,
        "2026-01-05.csv": False,
    }
    assert "warning: --date 'x+' matches no name of a log" in result.stderr


def test_the_logs_of_a_folder_give_one_model(fleet: SimpleNamespace, tmp_path: Path) -> None:
    result = each("folder", fleet.folder / "U1", fleet.folder / "U2", "-o", tmp_path / "fleet.csv")
    assert result.code == 0, result.stderr
    rows = table((tmp_path / "fleet.csv").read_text())
    assert [(row["unit"], row["file"]) for row in rows] == [
        ("U1", "U1/2026-01-03.csv; U1/2026-02-03.csv"),
        ("U2", "U2/2026-01-04.csv"),
    ]
    together = json.loads(
        run(
            "identify",
            fleet.first,
            fleet.folder / "U1" / "2026-02-03.csv",
            "--bench",
            CLUTCH,
            "--json",
        ).stdout
    )
    assert float(rows[0]["coulomb"]) == together["parameters"]["coulomb"]["value"]


def test_the_machine_s_view_has_what_each_alone_prints(fleet: SimpleNamespace) -> None:
    result = each("log", fleet.folder, "--date", DATE, "--json")
    facts = json.loads(result.stdout)
    alone = json.loads(run("identify", fleet.first, "--bench", CLUTCH, "--json").stdout)
    assert {"format": "identify/1", **facts["models"][0]["identification"]} == alone
    assert facts["models"][3]["identification"] is None
    found = facts["populations"]["coulomb"]
    assert found["unit"] == "N m"
    assert found["one_population"] is False
    assert found["conclusion"].startswith("no: units differ by")
    assert found["spread"] > 10.0 * found["expected"]


def test_parquet_holds_the_same_with_types(
    fleet: SimpleNamespace, made: SimpleNamespace, tmp_path: Path
) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    assert each("log", fleet.folder, "--date", DATE, "-o", tmp_path / "fleet.parquet").code == 3
    held = parquet.read_table(tmp_path / "fleet.parquet")
    assert tuple(held.column_names) == COLUMNS
    assert held.schema.field("inertia").metadata == {b"unit": b"kg m^2"}
    for row, cells in zip(held.to_pylist(), made.rows, strict=True):
        assert ("" if row["inertia"] is None else repr(row["inertia"])) == cells["inertia"]
        assert str(row["date"].date()) == cells["date"]


def test_models_have_names_of_their_own(tmp_path: Path) -> None:
    names = ("a/x.csv", "b/x.csv", "b/x.mat", "y.csv")
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert [one.name for one in groups(members([tmp_path]), "log")] == [
        "a/x",
        "b/x.csv",
        "b/x.mat",
        "y",
    ]
    assert [one.name for one in groups(members([tmp_path / "a", tmp_path / "b"]), "folder")] == [
        "a",
        "b",
    ]
    assert [one.name for one in groups(members([tmp_path]), "folder")] == ["a", "b", tmp_path.name]
    assert [one.name for one in groups(members([tmp_path / name for name in names]), "log")] == [
        "a/x",
        "b/x.csv",
        "b/x.mat",
        "y",
    ]
    assert [
        one.name for one in groups([FleetLog(tmp_path, LogName("../../other/x.csv"))], "log")
    ] == ["other/x"]


def test_refusals_are_one_line(fleet: SimpleNamespace, tmp_path: Path) -> None:
    for arguments, word in (
        (("log", fleet.folder, "--ramp", fleet.first), "--ramp does not work with --each"),
        (
            ("log", fleet.folder, "--plot", tmp_path / "a.svg"),
            "--plot does not work with --each",
        ),
        (("log", "-"), "not standard input"),
        (
            ("log", fleet.folder, "--cores", "2", "--cluster", "tcp://127.0.0.1:1"),
            "--cores applies to this machine",
        ),
        (("log", fleet.folder, "--cores", "0"), "--cores"),
        (("log", fleet.folder, "--date", "("), "not a regular expression"),
        (
            ("log", fleet.folder, "-o", tmp_path / "model.yaml"),
            "name a folder for models and table",
        ),
    ):
        result = each(*arguments)
        assert result.code == 2
        assert word in result.stderr
    result = run("identify", fleet.first, "--bench", CLUTCH, "--cores", "2")
    assert result.code == 2
    assert "--cores belongs to --each" in result.stderr
    (tmp_path / "file").touch()
    (tmp_path / "empty").mkdir()
    refused(each("log", fleet.folder, "-o", tmp_path / "file"), 3, "name a folder for the models")
    refused(each("log", tmp_path / "empty"), 3, "contains no log")
    refused(each("log", fleet.folder, "--cluster", "nowhere"), 3, "allowed: tcp://HOST:PORT")
    missing = each("log", fleet.first, tmp_path / "none.csv", "-o", tmp_path / "m")
    assert missing.code == 3
    assert "none.csv" in missing.stdout
    assert [path.name for path in (tmp_path / "m").rglob("*.yaml")] == ["2026-01-03.yaml"]
