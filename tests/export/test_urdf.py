"""`export --lang urdf`: two values change in a copy of the file, and every other byte stays."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from frictool.documents.model import Model
from frictool.documents.presliding import Presliding
from frictool.documents.quantity import Estimate
from frictool.documents.registry import load
from frictool.errors import InputFileError, NoSolutionError
from frictool.export.urdf import urdf_files
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.documentation_pages import ROOT

GOLDEN = Path(__file__).parent / "golden"
ARM = """<?xml version="1.0"?>
<!-- the arm's <joint name="elbow"/> in a comment -->
<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <link name="base"/> <link name="upper"/>
\t<joint name="shoulder" type="continuous">
\t\t<parent link="base"/><child link="upper"/>
\t\t<!-- measured in June --><dynamics friction = '0.5'
        damping="0.1"   spring="1 > 0"/>
\t</joint>
  <joint type="revolute" name="elbow">
    <parent link="base"/>
    <child link="upper"/>  <!-- last -->
  </joint>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="upper"/></joint>
  <transmission name="t"><joint name="elbow"/></transmission>
  <xacro:macro name="m"><joint name="wrist" type="continuous"><dynamics/></joint></xacro:macro>
</robot>
"""
SDF = """<sdf version="1.9"><model name="m"><!-- kept -->
  <joint name="j" type="revolute">
    <axis>
      <xyz>0 0 1</xyz>%s
    </axis>
  </joint></model></sdf>
"""


@pytest.fixture(scope="module")
def model() -> Model:
    made = load(ROOT / "configs/clutch/nonlinear.yaml", Model)
    assert made.laws is not None
    mechanics = replace(made.bench.mechanics, backlash=None, backlash_coulomb=None)
    today = made.parameters
    return replace(
        made,
        laws=None,
        bench=replace(made.bench, mechanics=mechanics),
        parameters=replace(today, viscous=replace(today.viscous, value=3.81e-4)),
    )


def patched(model: Model, path: Path, text: str | bytes, joint: str | None) -> str:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    files, _ = urdf_files(model, path, joint, ())
    out = files[path.name]
    assert isinstance(out, bytes)
    return out.decode("utf-8-sig")


def test_changes_two_values_and_nothing_else(model: Model, tmp_path: Path) -> None:
    out = patched(model, tmp_path / "arm.urdf", ARM, "shoulder")
    assert out == ARM.replace("friction = '0.5'", 'friction="0.12192"').replace(
        'damping="0.1"', 'damping="0.000381"'
    )


def test_adds_the_element_with_the_file_s_indentation_and_line_ends(
    model: Model, tmp_path: Path
) -> None:
    windows = ARM.replace("\n", "\r\n")
    out = patched(model, tmp_path / "arm.urdf", b"\xef\xbb\xbf" + windows.encode(), "elbow")
    added = '    <dynamics damping="0.000381" friction="0.12192"/>'
    assert out == windows.replace(
        '    <child link="upper"/>  <!-- last -->',
        f'    <child link="upper"/>\r\n{added}  <!-- last -->',
    )
    assert '<dynamics damping="0.000381" friction="0.12192"/></joint></xacro' in patched(
        model, tmp_path / "arm.xacro", ARM, "wrist"
    )


@pytest.mark.parametrize(
    "dynamics",
    [
        "",
        "\n      <dynamics/>",
        "\n      <dynamics><friction>9</friction><!-- x --></dynamics>",
        "\n      <dynamics><damping>1</damping><friction/><spring_stiffness>2</spring_stiffness>"
        "</dynamics>",
    ],
)
def test_sdf_holds_elements(model: Model, tmp_path: Path, dynamics: str) -> None:
    out = patched(model, tmp_path / "m.sdf", SDF % dynamics, None)
    (read,) = ElementTree.fromstring(out).iter("dynamics")
    assert read.findtext("damping") == "0.000381"
    assert read.findtext("friction") == "0.12192"
    assert len(read.findall("friction")) == len(read.findall("damping")) == 1
    assert ("<spring_stiffness>2<" in out) == ("spring" in dynamics)
    assert ("<!-- x -->" in out) == ("<!-- x -->" in dynamics)
    assert "<!-- kept -->" in out


@given(
    order=st.permutations(["damping", "friction", "other"]),
    gaps=st.lists(st.sampled_from([" ", "\n\t", "  "]), min_size=3, max_size=3),
    quote=st.sampled_from("\"'"),
    kept=st.text(
        st.characters(codec="utf-8", exclude_characters="<&\"'\r\n\t\0", exclude_categories=["C"])
    ),
    present=st.integers(0, 3),
)
def test_any_start_tag(
    model: Model,
    tmp_path_factory: pytest.TempPathFactory,
    order: list[str],
    gaps: list[str],
    quote: str,
    kept: str,
    present: int,
) -> None:
    tag = "<dynamics" + "".join(
        f"{gap}{name}={quote}{kept if name == 'other' else 7}{quote}"
        for name, gap in zip(order[:present], gaps, strict=False)
    )
    text = f'<robot name="é"><joint name="j" type="continuous">{tag}/><axis/></joint></robot>'
    path = tmp_path_factory.getbasetemp() / "any.urdf"
    (read,) = ElementTree.fromstring(patched(model, path, text, "j")).iter("dynamics")
    assert read.get("damping") == "0.000381"
    assert read.get("friction") == "0.12192"
    assert read.get("other") == (kept if "other" in order[:present] else None)


@pytest.mark.parametrize(
    ("text", "joint", "message"),
    [
        (ARM, None, "3 revolute or continuous joints (shoulder, elbow, wrist); name one"),
        (ARM, "knee", "no joint knee; found revolute or continuous joints: shoulder, elbow, wrist"),
        (ARM, "slide", "arm.urdf:14: joint slide is prismatic; allowed for a rotary axis"),
        (ARM.replace("wrist", "elbow"), "elbow", "2 joints are called elbow (lines 10, 16)"),
        ("<mujoco/>", "j", "found <mujoco>; allowed: <robot> (URDF) or <sdf>"),
        (ARM[:-4], "elbow", "arm.urdf:17: is not well-formed XML"),
        ("", "j", "is not well-formed XML: no element found"),
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot name="r"/>', "j", "declares an entity"),
        ("<robot/>".encode("utf-16"), "j", "UTF-16; save it as UTF-8"),
        (SDF.replace("axis", "axle") % "", "j", "joint j has no <axis>; add it"),
    ],
)
def test_refuses_what_it_cannot_patch(
    model: Model, tmp_path: Path, text: str | bytes, joint: str | None, message: str
) -> None:
    with pytest.raises(InputFileError) as caught:
        patched(model, tmp_path / "arm.urdf", text, joint)
    assert message in str(caught.value)


def test_the_command_writes_the_copy_and_names_what_is_left_out(tmp_path: Path) -> None:
    robot = tmp_path / "arm.urdf"
    robot.write_text(ARM)
    nonlinear = ROOT / "configs/clutch/nonlinear.yaml"
    call: list[Any] = ["export", nonlinear, "--lang", "urdf", "--into", robot]
    call += ["--joint", "elbow", "-o", tmp_path / "out"]
    left = ["backward", "regimes", "position", "backlash"]
    options = [word for name in left for word in ("--without", name)]
    refused(
        run(*call),
        4,
        "cannot represent backward (friction levels of the negative direction), regimes",
        " ".join(options),
    )
    said = run(*call, *options, "--json")
    assert said.code == 0
    report = json.loads(said.stdout)
    assert report["files"] == ["arm.urdf"]
    assert report["notes"][0].startswith("joint elbow, line 10: damping 0.0, friction 0.12192")
    assert "breakaway 0.1341 N m" in report["notes"][-1]
    assert 'friction="0.12192"' in (tmp_path / "out/arm.urdf").read_text()
    assert robot.read_text() == ARM


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--lang", "urdf"], 2, "needs --into FILE"),
        (["--lang", "urdf", "--into", "arm.urdf", "-o", "."], 3, "--in-place instead of --output"),
        (["--lang", "urdf", "--into", "arm.urdf", "-o", "arm.urdf"], 3, "or use --in-place"),
        (["--lang", "urdf", "--into", "arm.urdf", "--without", "x"], 2, "allowed: backward"),
        (["--lang", "urdf", "--number", "q15"], 2, "--number does not work with --lang urdf; "),
        (["--into", "arm.urdf"], 2, "--into does not work with --lang c; allowed: --lang urdf"),
    ],
)
def test_the_command_refuses(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    code: int,
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(ARM)
    result = run("export", ROOT / "configs/mass/model.yaml", "-o", "out", *options)
    assert result.code == code, result.stderr
    assert message in result.stderr
    assert Path("arm.urdf").read_text() == ARM
    assert not Path("out").exists()


def test_hysteresis_is_refused_unless_it_is_left_out(model: Model, tmp_path: Path) -> None:
    presliding = Presliding(
        "lugre",
        Estimate(1e-3, unit="rad", source="identified"),
        Estimate(300.0, unit="N m/rad", source="identified"),
        Estimate(0.1, unit="N m", source="identified"),
    )
    hysteretic = replace(model, presliding=presliding)
    path = tmp_path / "arm.urdf"
    with pytest.raises(NoSolutionError, match=r"cannot represent presliding .*--without"):
        patched(hysteretic, path, ARM, "elbow")
    plain = urdf_files(model, path, "elbow", ())[0]
    files, notes = urdf_files(hysteretic, path, "elbow", {"presliding"})
    assert files == plain
    assert "left out: presliding (hysteresis before breakaway)" in notes


def test_mujoco_reads_the_values(model: Model, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed")
    text = """<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
    <joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
    </robot>"""
    read = mujoco.MjModel.from_xml_string(patched(model, tmp_path / "r.urdf", text, "j"))
    assert read.dof_damping[0] == model.parameters.viscous.value
    assert read.dof_frictionloss[0] == model.parameters.coulomb.value


@pytest.mark.parametrize("name", ["arm.urdf", "arm.sdf"])
def test_golden_files(model: Model, tmp_path: Path, name: str) -> None:
    """The files differ in the two values of the elbow: comments, quotes and gaps stay."""
    before = (GOLDEN / name).read_bytes()
    after = (GOLDEN / name.replace(".", "_changed.")).read_bytes()
    path = tmp_path / name
    assert patched(model, path, before, "elbow").encode() == after
    path.write_bytes(after)
    assert patched(model, path, after, "elbow").encode() == after
    (changed,) = (
        (old, new)
        for old, new in zip(before.splitlines(), after.splitlines(), strict=True)
        if old != new
    )
    assert b"0.000381" in changed[1]
    assert b"0.12192" in changed[1]


IN_PLACE: list[Any] = ["export", ROOT / "configs/clutch/nonlinear.yaml", "--lang", "urdf"]
IN_PLACE += [
    word for name in ("backward", "regimes", "position", "backlash") for word in ("--without", name)
]


def test_the_file_is_changed_in_place(tmp_path: Path) -> None:
    robot, link = tmp_path / "arm.urdf", tmp_path / "link.urdf"
    robot.write_text(ARM)
    robot.chmod(0o751)
    link.symlink_to(robot.name)
    call = [*IN_PLACE, "--joint", "shoulder"]
    assert run(*call, "--into", robot, "-o", tmp_path / "out").code == 0
    assert robot.read_text() == ARM
    said = run(*call, "--into", link, "--in-place")
    assert said.code == 0, said.stderr
    assert robot.read_bytes() == (tmp_path / "out/arm.urdf").read_bytes()
    assert link.is_symlink()
    assert robot.stat().st_mode & 0o777 == 0o751
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm.urdf", "link.urdf", "out"]


def test_a_refusal_in_place_changes_nothing(tmp_path: Path) -> None:
    robot = tmp_path / "arm.urdf"
    robot.write_text(ARM)
    refused(run(*IN_PLACE, "--into", robot, "--joint", "knee", "--in-place"), 3, "no joint knee")
    assert robot.read_text() == ARM
    for options, message in (
        (["--in-place", "-o", tmp_path / "out"], "--in-place and --output exclude each other"),
        ([], "Missing option '-o' / '--output'"),
    ):
        result = run(*IN_PLACE, "--into", robot, "--joint", "elbow", *options)
        assert result.code == 2
        assert message in result.stderr
    table = run(*IN_PLACE[:2], "--lang", "table", "--in-place")
    assert table.code == 2
    assert "--in-place does not work with --lang table" in table.stderr
    assert robot.read_text() == ARM
