"""Controller as a Functional Mock-up Unit: FMI 3.0, co-simulation, as source code.

    NAME.fmu  modelDescription.xml           variables, units, period
              sources/buildDescription.xml   files to compile
              sources/NAME.c, NAME.h         the code of `--lang c`
              sources/fmi3_NAME.c            the functions of FMI

The unit executes one sample per period. The inputs at the start of a communication step give the
drive at its end, so that a drive acts one period after its measurement.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import jinja2

from frictool import __version__
from frictool.control.program import Program
from frictool.documents.controller import Controller, Number
from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError
from frictool.export.c_identifier import c_identifier, comment_text
from frictool.export.export_origin import ExportOrigin

FOLDER = Path(__file__).parent / "templates"
KINDS: dict[Number, tuple[str, str]] = {"double": ("double", "0.0"), "float": ("float", "0.0f")}
SIGNALS = {"reference": "position", "position": "position", "velocity": "velocity"}
BASE_UNITS = {  # exponents of the SI base units
    "s": {"s": 1},
    "rad": {"rad": 1},
    "m": {"m": 1},
    "rad/s": {"rad": 1, "s": -1},
    "m/s": {"m": 1, "s": -1},
    "A": {"A": 1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
}
NUMBERS = {
    "Float32": "float",
    **{
        f"{sign}Int{bits}": f"{kind}{bits}_t"
        for bits in (8, 16, 32, 64)
        for sign, kind in (("", "int"), ("U", "uint"))
    },
}
REFERENCES = ", const Reference references[], size_t count"
# functions that the standard requires and that return an error here: name -> other parameters
ABSENT = {
    "EnterEventMode": "",
    "EnterConfigurationMode": "",
    "ExitConfigurationMode": "",
    "EvaluateDiscreteStates": "",
    "EnterContinuousTimeMode": "",
    "EnterStepMode": "",
    "SetBoolean": f"{REFERENCES}, const bool values[], size_t size",
    **{
        f"Get{name}": f"{REFERENCES}, {kind} values[], size_t size"
        for name, kind in NUMBERS.items()
    },
    **{
        f"Set{name}": f"{REFERENCES}, const {kind} values[], size_t size"
        for name, kind in NUMBERS.items()
    },
    "GetString": f"{REFERENCES}, const char *values[], size_t size",
    "SetString": f"{REFERENCES}, const char *const values[], size_t size",
    "GetBinary": f"{REFERENCES}, size_t sizes[], const uint8_t *values[], size_t size",
    "SetBinary": f"{REFERENCES}, const size_t sizes[], const uint8_t *const values[], size_t size",
    "GetClock": f"{REFERENCES}, bool values[]",
    "SetClock": f"{REFERENCES}, const bool values[]",
    "GetNumberOfVariableDependencies": ", Reference variable, size_t *count",
    "GetVariableDependencies": ", Reference dependent, size_t elements[], Reference variables[], "
    "size_t indices[], int kinds[], size_t count",
    **{
        f"Get{kind}Derivative": ", const Reference unknowns[], size_t unknown_count, "
        "const Reference knowns[], size_t known_count, const double seed[], size_t seed_size, "
        "double sensitivity[], size_t size"
        for kind in ("Directional", "Adjoint")
    },
    "GetIntervalDecimal": f"{REFERENCES}, double intervals[], int qualifiers[]",
    "GetIntervalFraction": f"{REFERENCES}, uint64_t counters[], uint64_t resolutions[], "
    "int qualifiers[]",
    "GetShiftDecimal": f"{REFERENCES}, double shifts[]",
    "GetShiftFraction": f"{REFERENCES}, uint64_t counters[], uint64_t resolutions[]",
    "SetIntervalDecimal": f"{REFERENCES}, const double intervals[]",
    "SetIntervalFraction": f"{REFERENCES}, const uint64_t counters[], const uint64_t resolutions[]",
    "SetShiftDecimal": f"{REFERENCES}, const double shifts[]",
    "SetShiftFraction": f"{REFERENCES}, const uint64_t counters[], const uint64_t resolutions[]",
    "UpdateDiscreteStates": ", bool *update, bool *terminate, bool *nominals, bool *states, "
    "bool *defined, double *next",
    "CompletedIntegratorStep": ", bool no_earlier_state, bool *events, bool *terminate",
    "SetTime": ", double time",
    "SetContinuousStates": ", const double states[], size_t count",
    "GetContinuousStateDerivatives": ", double derivatives[], size_t count",
    "GetEventIndicators": ", double indicators[], size_t count",
    "GetContinuousStates": ", double states[], size_t count",
    "GetNominalsOfContinuousStates": ", double nominals[], size_t count",
    "GetNumberOfEventIndicators": ", size_t *count",
    "GetNumberOfContinuousStates": ", size_t *count",
    "GetOutputDerivatives": f"{REFERENCES}, const int32_t orders[], double values[], size_t size",
    "ActivateModelPartition": ", Reference clock, double time",
}
LAST_WORD = re.compile(r"(\w+)(?:\[\])?$")
OLDEST = (1980, 1, 1, 0, 0, 0)  # a ZIP archive stores no earlier date


def fmu_file(
    controller: Controller,
    program: Program,
    number: Number,
    sources: Mapping[str, str],
    origin: ExportOrigin,
) -> dict[str, bytes]:
    """Return the unit by its file name.

    Parameters
    ----------
    controller, program : Controller, Program
        The controller and its program.
    number : {"double", "float"}
        Number format of the code.
    sources : mapping of str to str
        Files of `--lang c`; the header and the source are used.
    origin : ExportOrigin
        Origin of the controller's document.

    Raises
    ------
    NoSolutionError
        If the number format is fixed point.
    """
    if number not in KINDS:
        raise NoSolutionError(
            f"{controller.name}: the variables of an FMU are doubles; found --number {number}; "
            "allowed: double, float"
        )
    name = c_identifier(controller.name)
    files = {
        "modelDescription.xml": _description(controller, program, origin),
        "sources/buildDescription.xml": _build(name),
        f"sources/{name}.h": sources[f"{name}.h"],
        f"sources/{name}.c": sources[f"{name}.c"],
        f"sources/fmi3_{name}.c": _functions(controller, program, number, origin),
    }
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, text in files.items():
            archive.writestr(zipfile.ZipInfo(path, OLDEST), text, zipfile.ZIP_DEFLATED)
    return {f"{name}.fmu": stream.getvalue()}


def _settings(program: Program) -> list[tuple[str, float]]:
    """Return each scheduled parameter and its first value."""
    return [
        (program.names[node.index], node.value)
        for node in program.states.values()
        if node.index not in program.updates
    ]


def _functions(
    controller: Controller, program: Program, number: Number, origin: ExportOrigin
) -> str:
    name = c_identifier(controller.name)
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER), undefined=jinja2.StrictUndefined, autoescape=False
    )
    environment.globals["comment"] = comment_text
    kind, zero = KINDS[number]
    inputs = list(program.inputs)
    absent = [
        (function, parameters, [LAST_WORD.search(one)[1] for one in parameters.split(",") if one])  # type: ignore[index]
        for function, parameters in ABSENT.items()
    ]
    text = environment.get_template("fmi3.c.jinja").render(
        id=name,
        ID=name.upper(),
        name=controller.name,
        command=origin.command,
        version=__version__,
        inputs=inputs,
        position=inputs.index("position"),
        held=[(one, repr(start)) for one, start in _settings(program)],
        kind=kind,
        zero=zero,
        period=repr(controller.sample_period_s),
        token=origin.sha256,
        absent=absent,
    )
    return text.rstrip("\n") + "\n"


def _build(name: str) -> str:
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<fmiBuildDescription fmiVersion="3.0">\n'
        f'  <BuildConfiguration modelIdentifier="{name}">\n'
        '    <SourceFileSet language="C99">\n'
        f'      <SourceFile name="{name}.c"/>\n'
        f'      <SourceFile name="fmi3_{name}.c"/>\n'
        "    </SourceFileSet>\n"
        "  </BuildConfiguration>\n"
        "</fmiBuildDescription>\n"
    )


def _variables(controller: Controller, program: Program) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the element of each variable with its attributes; the index is the reference."""
    yield "Float64", {"name": "time", "causality": "independent", "unit": "s"}
    for name in program.inputs:
        unit = si_unit(SIGNALS[name], controller.axis)
        yield "Float64", {"name": name, "causality": "input", "start": "0", "unit": unit}
    for name, start in _settings(program):
        yield "Float64", {"name": name, "causality": "input", "start": repr(start)}
    unit = si_unit(controller.drive, controller.axis)
    yield (
        "Float64",
        {"name": "drive", "causality": "output", "initial": "exact", "start": "0", "unit": unit},
    )
    yield "Boolean", {"name": "fault", "causality": "output", "initial": "calculated"}


def _description(controller: Controller, program: Program, origin: ExportOrigin) -> str:
    variables = list(_variables(controller, program))
    units = dict.fromkeys(one["unit"] for _, one in variables if "unit" in one)
    rows = []
    for reference, (element, attributes) in enumerate(variables):
        words = {"valueReference": str(reference), **attributes}
        words["variability"] = "continuous" if reference == 0 else "discrete"
        rows.append(f"    {_element(element, words)}")
    position = 1 + list(program.inputs).index("position")
    drive, fault = len(variables) - 2, len(variables) - 1
    head = {
        "fmiVersion": "3.0",
        "modelName": controller.name,
        "instantiationToken": origin.sha256,
        "description": f"{origin.command}; controller SHA-256 {origin.sha256}",
        "generationTool": f"frictool {__version__}",
    }
    simulation = {
        "modelIdentifier": c_identifier(controller.name),
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "canHandleVariableCommunicationStepSize": "true",
        "fixedInternalStepSize": repr(controller.sample_period_s),
    }
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        _element("fmiModelDescription", head).removesuffix("/>") + ">",
        f"  {_element('CoSimulation', simulation)}",
        "  <UnitDefinitions>",
        *(f'    <Unit name="{unit}">{_base(unit)}</Unit>' for unit in units),
        "  </UnitDefinitions>",
        f'  <DefaultExperiment stepSize="{controller.sample_period_s!r}"/>',
        "  <ModelVariables>",
        *rows,
        "  </ModelVariables>",
        "  <ModelStructure>",
        f'    <Output valueReference="{drive}"/>',
        f'    <Output valueReference="{fault}"/>',
        f'    <InitialUnknown valueReference="{fault}" dependencies="{position}"/>',
        "  </ModelStructure>",
        "</fmiModelDescription>",
    ]
    return "\n".join(lines) + "\n"


def _base(unit: str) -> str:
    return _element("BaseUnit", {base: str(power) for base, power in BASE_UNITS[unit].items()})


def _element(name: str, attributes: Mapping[str, str]) -> str:
    words = [name, *(f"{key}={quoteattr(text)}" for key, text in attributes.items())]
    return f"<{' '.join(words)}/>"
