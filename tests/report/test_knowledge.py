"""Each requirement says how its outcome is known."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from frictool.cli.report import _proof as read
from frictool.documents.proof import Proof, ProvedRequirement, proof_digest
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.writing import to_yaml
from frictool.errors import DocumentError
from frictool.logs.log import Log
from frictool.report.json_view import as_json
from frictool.report.knowledge import BOX_PROVED, CERTIFIED, PROVED
from frictool.report.markdown_view import markdown
from frictool.report.requirement import ReportRequest, Verdict
from frictool.report.verdict import judge, verdict_of
from studies.rigs.clutch_model import ROOT, clutch_model
from studies.rigs.step_logs import clutch_spec, controller, stream
from tests.support.certified_controllers import certified

HELD = PROVED.format("nominal, v01")
RECORDED = Log((stream(),), {}, "run.mcap")
SIMULATED = Log((stream(),), {"log": {"kind": "simulated"}}, "run.mcap")


def _known(verdict: Verdict) -> dict[str, str]:
    return {one.key: one.known for one in verdict.requirements}


def _proof(state: str, value: float) -> Proof:
    spec = clutch_spec()
    proof = Proof(
        format="proof/1",
        name="a proof",
        axis="rotary",
        number="double",
        plants=("nominal", "v01"),
        starts=(4.9, 5.0),
        runs=1,
        open_share=0.0,
        requirements=(
            ProvedRequirement("overshoot_percent", state, 5.0, value),  # type: ignore[arg-type]
        ),
        model=clutch_model(),
        controller=certified("speed"),
        scenario=load(ROOT / "configs/clutch/scenarios/prove.yaml", Scenario),
        spec=spec,
        provenance=Provenance("a test", "0"),
    )
    return msgspec.structs.replace(proof, digest=proof_digest(proof))


def test_a_recorded_log_is_measured_and_a_simulated_one_simulated() -> None:
    assert _known(judge(clutch_spec(), [RECORDED]))["overshoot_percent"] == "measured in 1 stream"
    found = _known(judge(clutch_spec(), [SIMULATED], controller()))
    assert found["overshoot_percent"] == "simulated on 1 plant"


def test_the_margin_of_a_certificate_is_proved() -> None:
    verdict = judge(clutch_spec(), [RECORDED], certified("speed"))
    assert _known(verdict)["modulus_margin"] == CERTIFIED
    bare = msgspec.structs.replace(certified("speed"), certificate=None)
    assert _known(judge(clutch_spec(), [RECORDED], bare))["modulus_margin"] == (
        "computed for the plants"
    )


def test_a_proof_counts_within_its_value_only() -> None:
    for state, value, counts in (("proved", 1.0, True), ("proved", 6.0, False),
                                 ("undecided", 1.0, False)):  # fmt: skip
        request = ReportRequest(
            clutch_spec(), (RECORDED,), certified("speed"), proof=_proof(state, value)
        )
        verdict = verdict_of(request)
        assert (HELD in _known(verdict)["overshoot_percent"]) == counts
        assert HELD not in _known(verdict)["static_error"]
        assert (HELD in markdown(verdict)) == counts
        stored = {one["key"]: one["known"] for one in as_json(verdict)["requirements"]}
        assert stored == _known(verdict)


def test_a_bound_for_the_box_counts_within_the_limit_of_the_report_only() -> None:
    for bound, counts in ((5.0, True), (5.1, False)):
        proof = _proof("proved", 1.0)
        claim = msgspec.structs.replace(proof.requirements[0], box=bound)
        boxed = msgspec.structs.replace(proof, requirements=(claim,))
        request = ReportRequest(clutch_spec(), (RECORDED,), certified("speed"), proof=boxed)
        known = _known(verdict_of(request))["overshoot_percent"]
        assert (BOX_PROVED in known) == counts
        assert (HELD in known) != counts  # beyond the limit, the single plants still count


def test_a_share_of_the_box_counts_within_the_limit_of_the_proof_only() -> None:
    for limit, counts in ((5.0, True), (5.1, False)):
        proof = _proof("proved", 1.0)
        claim = msgspec.structs.replace(proof.requirements[0], share=0.125, limit=limit)
        boxed = msgspec.structs.replace(proof, requirements=(claim,))
        request = ReportRequest(clutch_spec(), (RECORDED,), certified("speed"), proof=boxed)
        known = _known(verdict_of(request))["overshoot_percent"]
        assert ("12.5 % of the box" in known) == counts
        assert HELD in known


@pytest.mark.parametrize("fault", ["digest", "controller"])
def test_an_edited_or_foreign_proof_is_refused(tmp_path: Path, fault: str) -> None:
    proof, own = _proof("proved", 1.0), certified("speed")
    path = tmp_path / "proof.yaml"
    if fault == "digest":
        proof = msgspec.structs.replace(proof, runs=2)
    else:
        own = msgspec.structs.replace(own, name="another")
    path.write_text(to_yaml(proof))
    with pytest.raises(DocumentError, match=fault):
        read(path, own)
