"""No edit of a controller document passes `verify` in silence.

Edits of a block with a digest are seen by it. Edits of the figures under `verified`, and edits
whose author makes the digests anew, are seen because everything is computed again.
"""

from __future__ import annotations

import functools
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from frictool.documents.certificate import Bound, Certificate
from frictool.documents.controller import Controller, DelayCheck
from frictool.documents.digests import GIVEN, SOLVED, changed_blocks, with_digests
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.verify import document_check as controller_checks
from frictool.verify import recheck
from frictool.verify.loop_values import LinearLoops
from studies.command_line import run
from tests.support.certified_controllers import Named, certified, few_interior_points
from tests.support.command_line import refused
from tests.support.controller_edits import Edit, edits

SEED = 20261123
# edits of the vertices' figures, of which there are half a thousand, and of those that are judged
# with new digests
DRAWN = 24
LEAST = 132
ALL = ("speed", pytest.param("fast", marks=pytest.mark.accept), "pi_speed")


def _edits(name: Named) -> tuple[Edit, ...]:
    return edits(msgspec.json.decode(msgspec.json.encode(certified(name))))


def _read(edit: Edit) -> Controller | None:
    """The edited document; None where it is refused as it is read."""
    try:
        return msgspec.convert(edit.document, Controller)
    except msgspec.ValidationError:
        return None


def _silent(document: Controller) -> bool:
    try:
        return recheck.verify(document).unaltered
    except NoSolutionError:
        return False


@pytest.fixture(scope="module", autouse=True)
def _figures_once() -> Iterator[None]:
    """Figures and proofs that an edit does not reach are computed once for all tests: each is kept
    by everything that it is computed of."""
    proofs: list[tuple[Controller, tuple[Bound, ...]]] = []
    checks: dict[bytes, tuple[DelayCheck, ...]] = {}
    prove, check = recheck.prove_document, controller_checks.loop_checks

    def proved_once(controller: Controller, certificate: Certificate) -> tuple[Bound, ...]:
        for known, proved in proofs:
            if msgspec.structs.replace(controller, verified=known.verified) == known:
                return proved
        proofs.append((controller, prove(controller, certificate)))
        return proofs[-1][1]

    def checked_once(*given: Any) -> tuple[DelayCheck, ...]:
        key = pickle.dumps(given)
        if key not in checks:
            checks[key] = check(*given)
        return checks[key]

    with few_interior_points(), pytest.MonkeyPatch.context() as patch:
        for name in ("vertex", "count_drive", "margins", "rounded", "seen_inside"):
            patch.setattr(LinearLoops, name, functools.cache(getattr(LinearLoops, name)))
        patch.setattr(recheck, "prove_document", proved_once)
        patch.setattr(controller_checks, "loop_checks", checked_once)
        yield


@pytest.mark.parametrize("name", ALL)
def test_what_synthesis_wrote_passes(name: Named) -> None:
    assert _silent(certified(name))


@pytest.mark.parametrize("name", ALL)
def test_every_edit_of_a_block_is_seen(name: Named) -> None:
    counted = [edit for edit in _edits(name) if edit.block != "verified"]
    documents = {edit.label: _read(edit) for edit in counted}
    assert len(documents) >= LEAST
    assert [
        label
        for label, document in documents.items()
        if document is not None and not changed_blocks(document)
    ] == []
    read = [edit for edit in counted if documents[edit.label] is not None]
    named = [changed_blocks(document)[0] for document in documents.values() if document is not None]
    header = ("sample_period_s", "delay_samples", "drive_limit")
    assert named == ["header" if edit.block in header else edit.block for edit in read]


@pytest.mark.parametrize("name", ALL)
def test_every_edit_of_a_figure_is_seen(name: Named) -> None:
    counted = [edit for edit in _edits(name) if edit.block == "verified"]
    drawn = np.random.default_rng(SEED).choice(len(counted), DRAWN, replace=False)
    kept = {edit.label: edit for edit in counted if "vertices" not in edit.label} | {
        counted[k].label: counted[k] for k in drawn
    }
    assert len(kept) >= 50
    assert [
        label
        for label, edit in kept.items()
        if (document := _read(edit)) is not None and _silent(document)
    ] == []


def _true_anew(label: str) -> bool:
    """Return whether the document with new digests claims nothing false: a requirement, a solver's
    bound, or a weaker bound."""
    key, _, change = label.partition(" ")
    last = key.rpartition(".")[2]
    return (
        last in GIVEN
        or (last in SOLVED and change == "x1.5")
        or (last == "below" and change == "x1.5")
    )


@pytest.mark.parametrize("name", ALL)
def test_edits_with_new_digests_are_seen_by_what_is_computed(name: Named) -> None:
    """The box, the bounds and the weights of a norm, the vertices, the bench's intervals and the
    figures do not rest on digests."""
    weighted = certified(name).judged_by is not None
    stated = (
        "certificate.box",
        *(("certificate.weights",) if weighted else ()),
        "certificate.bounds deleted",
        "certificate.bounds without",
        "verified",
    )
    measured = (
        "sample_period_s",
        "delay_samples",
        "drive_limit",
        "bench.actuator.loop",
        "bench.encoder",
        "bench.actuator.limit.value",
    )
    counted = [
        edit
        for edit in _edits(name)
        if edit.label.startswith((*stated, *measured)) and not _true_anew(edit.label)
    ]
    documents = {edit.label: document for edit in counted if (document := _read(edit)) is not None}
    drawn = np.random.default_rng(SEED + 1).choice(sorted(documents), DRAWN // 2, replace=False)
    at_least = (
        "certificate.box.inertia[1] x1.5",
        f"certificate.bounds without {int(weighted)}",
        *(
            ("certificate.weights.disturbance x0.5",)
            if weighted
            else ("certificate.bounds deleted",)
        ),
    )
    assert [label for label in {*drawn, *at_least} if _silent(with_digests(documents[label]))] == []


def test_a_box_of_one_vertex_is_refused_whatever_its_digests_say() -> None:
    controller = certified("speed")
    first = controller.verified.vertices[0]
    assert controller.certificate is not None
    one = {
        name: (getattr(first, name),) * 2 for name in ("inertia", "viscous", "coulomb", "constant")
    }
    certificate = msgspec.structs.replace(
        controller.certificate, box=type(controller.certificate.box)(**one)
    )
    verified = msgspec.structs.replace(
        controller.verified, vertices=(first,), gamma_verified=first.sampled_norm
    )
    shrunk = with_digests(
        msgspec.structs.replace(controller, certificate=certificate, verified=verified)
    )
    with pytest.raises(
        NoSolutionError,
        match=r"inertia is 1\.11e-05 to 1\.53e-05 in the bench, "
        r"but 1\.11e-05 to 1\.11e-05 in the certificate",
    ):
        recheck.verify(shrunk)
    without = with_digests(
        msgspec.structs.replace(shrunk, certificate=None, weights=certificate.weights)
    )
    with pytest.raises(NoSolutionError, match=r"inertia is .* in the bench"):
        recheck.verify(without)


def test_whoever_relies_on_a_changed_controller_is_warned(tmp_path: Path) -> None:
    """No verified figure depends on a position law's gain, so that the C is written; the block is
    named."""
    path, edit = (
        tmp_path / "controller.yaml",
        next(edit for edit in _edits("speed") if edit.label == "position_law.gain x1.5"),
    )
    document = _read(edit)
    assert document is not None
    for written, warned in ((certified("speed"), False), (document, True)):
        path.write_text(to_yaml(written))
        result = run("export", path, "--lang", "json", "-o", tmp_path / "c")
        assert result.code == 0
        assert (
            "controller.yaml: changed after it was verified: position_law; `frictool verify`"
            in result.stderr
        ) == warned
        assert result.stderr.count("\n") == warned


def test_a_controller_with_its_vertices_deleted_is_not_exported(tmp_path: Path) -> None:
    path, edit = (
        tmp_path / "controller.yaml",
        next(edit for edit in _edits("speed") if edit.label == "verified.vertices first 1 kept"),
    )
    document = _read(edit)
    assert document is not None
    assert document.certificate is not None
    path.write_text(to_yaml(document))
    corner = "inertia 1.11e-05 kg m^2, viscous 0 N m s/rad, coulomb 0.018 N m, constant 0.014 N m/A"
    refused(
        run("export", path, "-o", tmp_path / "c"),
        4,
        f"the certificate's intervals have a corner that is no vertex of the document: {corner}",
    )
    path.write_text(
        to_yaml(
            msgspec.structs.replace(
                document, certificate=None, weights=document.certificate.weights
            )
        )
    )
    refused(
        run("export", path, "-o", tmp_path / "c"),
        4,
        "inertia is 1.11e-05 to 1.53e-05 in the bench, but 1.11e-05 to 1.11e-05 in the vertices",
    )


def test_the_command_names_the_edit(tmp_path: Path) -> None:
    """One edit of each kind, as a shell sees it."""
    by_label = {edit.label: edit for edit in _edits("speed")}
    seen = {
        "position_law.gain x1.5": "changed after verification: position_law",
        "prefilter.damping x0.5": "changed after verification: prefilter",
        "certificate.weights.error.gain x0.5": "",
        "verified.gamma_verified x0.5": "verified.gamma_verified: found ",
        "verified.count_drive x1.5": "verified.count_drive: found ",
        "verified.margins.phase_deg x1.5": "verified.margins.phase_deg: found ",
        "verified.robustness.interior x0.5": "verified.robustness.interior: found ",
        "verified.vertices first 1 kept": "verified.vertices: found 1 entries, the coefficients "
        "give 16 entries",
        "verified.rounded without 3": "verified.rounded: found 3 entries, the coefficients give 4 "
        "entries",
        "certificate.bounds without 1": "certificate.bounds has no bound of the sensitivity",
        "certificate.bounds deleted": "certificate.bounds has no bound of the norm",
    }
    for label, words in seen.items():
        path = tmp_path / "controller.yaml"
        document = _read(by_label[label])
        assert document is not None
        path.write_text(to_yaml(document))
        result = run("verify", path)
        assert result.code in (1, 4), label
        assert words in result.stdout + result.stderr, (label, result)
