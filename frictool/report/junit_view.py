"""JUnit XML view of the verdict, with one test case per requirement for build servers."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from frictool.presentation.sections import plain
from frictool.report.requirement import Requirement, Verdict, number


def junit(verdict: Verdict, allow_undecided: bool = False) -> str:
    """Return the verdict as the XML of a test suite.

    The property `verdict` is `pass`, `fail` or `undecided`. A requirement that is not met is a
    failure, and an undecided requirement is an error. If `allow_undecided` is True and the verdict
    is acceptable, an undecided requirement is a skipped test, which build servers count as a
    success.
    """
    requirements = verdict.requirements
    skip = verdict.acceptable(allow_undecided)
    undecided = len(verdict.undecided)
    counts = {
        "tests": str(len(requirements)),
        "failures": str(sum(r.met is False for r in requirements)),
        "errors": str(0 if skip else undecided),
        "skipped": str(undecided if skip else 0),
        "time": "0",
    }
    name = plain(verdict.name)
    root = ET.Element("testsuites", {"name": "frictool report", **counts})
    suite = ET.SubElement(root, "testsuite", {"name": name, **counts})
    properties = ET.SubElement(suite, "properties")
    for key, value in (
        ("verdict", verdict.state),
        ("summary", verdict.headline),
        *(("warning", remark) for remark in verdict.remarks),
    ):
        ET.SubElement(properties, "property", {"name": key, "value": plain(value)})
    for requirement in requirements:
        _case(suite, name, requirement, skip)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _case(suite: ET.Element, name: str, requirement: Requirement, skip: bool) -> None:
    case = ET.SubElement(
        suite, "testcase", {"classname": f"frictool.{name}", "name": requirement.name, "time": "0"}
    )
    unit = f" {requirement.unit}".rstrip()
    figures = (
        f"{number(requirement.value)}{unit}, limit {requirement.relation} "
        f"{number(requirement.limit)}{unit}"
    )
    where = f", {requirement.where}" if requirement.where else ""
    message = plain(f"{figures}{where}" + (f": {requirement.reason}" if requirement.reason else ""))
    if requirement.met is None and skip:
        ET.SubElement(case, "skipped", {"message": plain(f"undecided: {requirement.reason}")})
    elif requirement.met is None:
        ET.SubElement(
            case,
            "error",
            {"type": "undecided", "message": plain(f"undecided: {requirement.reason}")},
        )
    elif not requirement.met:
        ET.SubElement(case, "failure", {"type": "requirement", "message": f"not met: {message}"})
    else:
        ET.SubElement(case, "system-out").text = message
