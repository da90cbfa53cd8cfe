"""Functional Mock-up Unit: FMI 3.0, co-simulation, as source code.

    NAME.fmu  modelDescription.xml           variables, units, period
              sources/buildDescription.xml   files to compile
              sources/fmi3_NAME.c            the functions of FMI, and other sources

`templates/fmi3.c.jinja` contains the functions that all units share.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Literal
from xml.sax.saxutils import quoteattr

import jinja2

from frictool import __version__
from frictool.export.c_identifier import c_identifier, comment_text
from frictool.export.export_origin import ExportOrigin

FOLDER = Path(__file__).parent / "templates"
BASE_UNITS = {  # exponents of the SI base units
    "s": {"s": 1},
    "rad": {"rad": 1},
    "m": {"m": 1},
    "rad/s": {"rad": 1, "s": -1},
    "m/s": {"m": 1, "s": -1},
    "A": {"A": 1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "kg m^2": {"kg": 1, "m": 2},
    "kg": {"kg": 1},
    "N m": {"kg": 1, "m": 2, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N m s/rad": {"kg": 1, "m": 2, "s": -1, "rad": -1},
    "N s/m": {"kg": 1, "s": -1},
    "N m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1},
    "N/m": {"kg": 1, "s": -2},
    "N m/A": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "N/A": {"kg": 1, "m": 1, "s": -2, "A": -1},
    "N m/V": {"s": 1, "A": 1},
    "N/V": {"m": -1, "s": 1, "A": 1},
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
# functions that FMI requires and that only return an error here: name -> further parameters
ABSENT = {
    "EnterEventMode": "",
    "EnterConfigurationMode": "",
    "ExitConfigurationMode": "",
    "EvaluateDiscreteStates": "",
    "EnterContinuousTimeMode": "",
    "EnterStepMode": "",
    "GetBoolean": f"{REFERENCES}, bool values[], size_t size",
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


@dataclass(frozen=True)
class FmiVariable:
    """Variable of a unit.

    - reference: value reference
    - kind: type of the variable
    - attributes: additional attributes of the variable's XML element
    - depends_on: value references of the inputs and parameters that determine the initial value
    """

    reference: int
    kind: Literal["Float64", "Boolean", "Int64", "Enumeration"]
    attributes: Mapping[str, str]
    depends_on: tuple[int, ...] = ()


@dataclass(frozen=True)
class FmiUnit:
    """Content of a unit.

    - name: name of the model or controller
    - document: kind of document that is exported
    - origin: origin of the document
    - period: default communication step [s]
    - variables: variables; the first variable is the time
    - functions: C file with the functions of FMI
    - sources: C files and headers, without the functions of FMI
    - is_sampled: True if the unit executes one sample per period
    - enumerations: items of each enumeration type
    """

    name: str
    document: Literal["controller", "model"]
    origin: ExportOrigin
    period: float
    variables: tuple[FmiVariable, ...]
    functions: str
    sources: Mapping[str, str] = field(default_factory=dict)
    is_sampled: bool = False
    enumerations: Mapping[str, Mapping[str, int]] = field(default_factory=dict)

    def files(self) -> dict[str, bytes]:
        """Return the files of the unit (contents by file name)."""
        name = c_identifier(self.name)
        sources = {**self.sources, f"fmi3_{name}.c": self.functions}
        files = {
            "modelDescription.xml": self._description(),
            "sources/buildDescription.xml": _build(name, sources),
            **{f"sources/{file}": text for file, text in sources.items()},
        }
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
            for path, text in files.items():
                archive.writestr(zipfile.ZipInfo(path, OLDEST), text, zipfile.ZIP_DEFLATED)
        return {f"{name}.fmu": stream.getvalue()}

    def _description(self) -> str:
        units = dict.fromkeys(
            one.attributes["unit"] for one in self.variables if "unit" in one.attributes
        )
        rows = [
            _element(one.kind, {"valueReference": str(one.reference), **one.attributes})
            for one in self.variables
        ]
        outputs = [one for one in self.variables if one.attributes.get("causality") == "output"]
        initial = [one for one in outputs if one.attributes["initial"] == "calculated"]
        head = {
            "fmiVersion": "3.0",
            "modelName": self.name,
            "instantiationToken": self.origin.sha256,
            "description": f"{self.origin.command}; {self.document} SHA-256 {self.origin.sha256}",
            "generationTool": f"frictool {__version__}",
        }
        simulation = {
            "modelIdentifier": c_identifier(self.name),
            "canGetAndSetFMUState": "true",
            "canSerializeFMUState": "true",
            "canHandleVariableCommunicationStepSize": "true",
        }
        if self.is_sampled:
            simulation["fixedInternalStepSize"] = repr(self.period)
        lines = [
            '<?xml version="1.0" encoding="UTF-8"?>',
            _element("fmiModelDescription", head).removesuffix("/>") + ">",
            f"  {_element('CoSimulation', simulation)}",
            "  <UnitDefinitions>",
            *(f'    <Unit name="{unit}">{_base(unit)}</Unit>' for unit in units),
            "  </UnitDefinitions>",
            *_types(self.enumerations),
            f'  <DefaultExperiment stepSize="{self.period!r}"/>',
            "  <ModelVariables>",
            *(f"    {row}" for row in rows),
            "  </ModelVariables>",
            "  <ModelStructure>",
            *(f'    <Output valueReference="{one.reference}"/>' for one in outputs),
            *(f"    {_initial_unknown(one)}" for one in initial),
            "  </ModelStructure>",
            "</fmiModelDescription>",
        ]
        return "\n".join(lines) + "\n"


def functions_text(
    template: str, origin: ExportOrigin, provided: Collection[str], **values: Any
) -> str:
    """Return the C file with the functions of FMI.

    - template: template that extends `fmi3.c.jinja`
    - origin: origin of the document
    - provided: functions of `ABSENT` that the template provides
    - values: values of the template
    """
    absent = [
        (function, parameters, [LAST_WORD.search(one)[1] for one in parameters.split(",") if one])  # type: ignore[index]
        for function, parameters in ABSENT.items()
        if function not in provided
    ]
    values |= {"command": origin.command, "version": __version__, "token": origin.sha256}
    return _environment().get_template(template).render(absent=absent, **values).rstrip("\n") + "\n"


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER), undefined=jinja2.StrictUndefined, autoescape=False
    )
    environment.globals["comment"] = comment_text
    environment.globals["c"] = environment.filters["c"] = _c_number
    return environment


def _c_number(value: float) -> str:
    return repr(float(value)).replace("inf", "INFINITY")


def _build(name: str, sources: Iterable[str]) -> str:
    compiled = [file for file in sources if file.endswith(".c")]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<fmiBuildDescription fmiVersion="3.0">',
        f'  <BuildConfiguration modelIdentifier="{name}">',
        '    <SourceFileSet language="C99">',
        *(f'      <SourceFile name="{file}"/>' for file in compiled),
        "    </SourceFileSet>",
        "  </BuildConfiguration>",
        "</fmiBuildDescription>",
    ]
    return "\n".join(lines) + "\n"


def _types(enumerations: Mapping[str, Mapping[str, int]]) -> list[str]:
    lines = []
    for name, items in enumerations.items():
        lines.append(f'    <EnumerationType name="{name}">')
        lines += [
            f"      {_element('Item', {'name': item, 'value': str(value)})}"
            for item, value in items.items()
        ]
        lines.append("    </EnumerationType>")
    return ["  <TypeDefinitions>", *lines, "  </TypeDefinitions>"] if lines else []


def _initial_unknown(variable: FmiVariable) -> str:
    words = {
        "valueReference": str(variable.reference),
        "dependencies": " ".join(map(str, variable.depends_on)),
    }
    return _element("InitialUnknown", words)


def _base(unit: str) -> str:
    return _element("BaseUnit", {base: str(power) for base, power in BASE_UNITS[unit].items()})


def _element(name: str, attributes: Mapping[str, str]) -> str:
    words = [name, *(f"{key}={quoteattr(text)}" for key, text in attributes.items())]
    return f"<{' '.join(words)}/>"
