"""FMI units compiled strictly from the files of their build description, and played with FMPy."""

from __future__ import annotations

import io
import subprocess
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from tests.support.compiled_c import COMPILERS, STRICT


def source_files(folder: Path) -> list[str]:
    """The C files of an extracted unit."""
    build = ElementTree.parse(folder / "sources/buildDescription.xml")
    return [str(folder / "sources" / one.attrib["name"]) for one in build.iter("SourceFile")]


def extracted(
    content: bytes, folder: Path, compiler: str = "", options: tuple[str, ...] = ()
) -> Path:
    """The folder of a unit with its binary."""
    if not COMPILERS:
        pytest.skip("no C compiler: neither gcc nor clang is on the PATH")
    fmpy = pytest.importorskip("fmpy", reason="fmpy is not installed")
    zipfile.ZipFile(io.BytesIO(content)).extractall(folder)
    target = folder / "binaries" / fmpy.platform_tuple
    target.mkdir(parents=True)
    description = ElementTree.parse(folder / "modelDescription.xml").getroot()
    simulation = description.find("CoSimulation")
    assert simulation is not None
    library = target / f"{simulation.attrib['modelIdentifier']}.so"
    command = [COMPILERS[0], *STRICT, "-O1", "-shared", "-fPIC"]
    done = subprocess.run(
        [*command, *source_files(folder), "-o", str(library), "-lm"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder


class Unit:
    """An instance of an extracted unit whose variables are addressed by their names."""

    def __init__(self, folder: Path, **starts: float) -> None:
        from fmpy import read_model_description
        from fmpy.fmi3 import FMU3Slave

        self.description = read_model_description(str(folder), validate=True)
        self.variables = {one.name: one for one in self.description.modelVariables}
        self.slave = FMU3Slave(
            guid=self.description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="unit",
        )
        self.time = 0.0
        self.slave.instantiate()
        self.set(**starts)
        self.start()

    def start(self) -> None:
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def set(self, **values: float) -> None:
        references = [self.variables[name].valueReference for name in values]
        self.slave.setFloat64(references, list(values.values()))

    def get(self, *names: str) -> list[Any]:
        """Values of numbers, or of enumerations and counts."""
        references = [self.variables[name].valueReference for name in names]
        if all(self.variables[name].type == "Float64" for name in names):
            return list(self.slave.getFloat64(references))
        return list(self.slave.getInt64(references))

    def step(self, duration: float) -> None:
        self.slave.doStep(self.time, duration)
        self.time += duration
