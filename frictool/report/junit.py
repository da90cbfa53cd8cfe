"""The verdict as JUnit XML: one test case per requirement, so that a build server shows what broke."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from frictool.report.requirement import Requirement, Verdict, number
from frictool.report.text import printable


def junit(verdict: Verdict) -> str:
    """A requirement that is broken is a failure, one that the logs cannot tell is skipped; where none is decided the suite is an error."""
    requirements = verdict.requirements
    undecided = not any(r.met is not None for r in requirements)
    counts = {
        "tests": str(len(requirements) + undecided),
        "failures": str(sum(r.met is False for r in requirements)),
        "errors": str(int(undecided)),
        "skipped": str(sum(r.met is None for r in requirements)),
        "time": "0",
    }
    name = printable(verdict.name)
    root = ET.Element("testsuites", {"name": "frictool report", **counts})
    suite = ET.SubElement(root, "testsuite", {"name": name, **counts})
    for requirement in requirements:
        _case(suite, name, requirement)
    if undecided:
        case = ET.SubElement(suite, "testcase", {"classname": f"frictool.{name}", "name": "verdict", "time": "0"})
        ET.SubElement(case, "error", {"type": "undecided", "message": verdict.headline})
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _case(suite: ET.Element, name: str, requirement: Requirement) -> None:
    case = ET.SubElement(suite, "testcase", {"classname": f"frictool.{name}", "name": requirement.name, "time": "0"})
    unit = f" {requirement.unit}".rstrip()
    told = f"{number(requirement.value)}{unit}, limit {requirement.relation} {number(requirement.limit)}{unit}"
    place = f", {requirement.where}" if requirement.where else ""
    message = printable(f"{told}{place}" + (f": {requirement.reason}" if requirement.reason else ""))
    if requirement.met is None:
        ET.SubElement(case, "skipped", {"message": printable(requirement.reason)})
    elif not requirement.met:
        ET.SubElement(case, "failure", {"type": "requirement", "message": f"not met: {message}"})
    else:
        ET.SubElement(case, "system-out").text = message
