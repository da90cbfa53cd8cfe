"""Inputs of `frictool campaign`: loading of the documents, and checks that they fit together."""

from __future__ import annotations

import hashlib
import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictool.cli.console_output import note, note_changes

if TYPE_CHECKING:
    from frictool.campaign.trials.trial_player import CampaignSetting, TrialPlayer
    from frictool.campaign.trials.worst_case import Commands
    from frictool.documents.controller import ProgramNumber
    from frictool.documents.mechanism import Mechanism
    from frictool.documents.model import Model

PACKAGE = Path(__file__).parents[1]


@dataclass(frozen=True)
class CampaignPaths:
    """Paths of the input files of a campaign; `recorded` is the log that the scenario replays."""

    model: Path
    controller: Path
    scenario: Path
    spec: Path
    observer: Path | None
    recorded: Path | None = None

    @property
    def inputs(self) -> dict[str, Path]:
        """Return all paths that are not None, by the name of the field."""
        return {name: path for name, path in vars(self).items() if path is not None}


def setting_of(
    paths: CampaignPaths, number: ProgramNumber
) -> tuple[CampaignSetting, CampaignPaths]:
    """Load the documents; return the settings of the campaign, and `paths`.

    If the scenario replays a log, the returned paths contain the log. `number`: number format of
    the controller. Raises InputFileError if the documents do not fit together.
    """
    from frictool.campaign.trials.trial_player import CampaignSetting
    from frictool.campaign.trials.varied_space import check_requirements
    from frictool.cli.simulate_inputs import recorded_log, with_observer_option
    from frictool.documents.controller import Controller
    from frictool.documents.model import Model
    from frictool.documents.registry import load, same_axis
    from frictool.documents.scenario import Scenario
    from frictool.documents.spec import Spec
    from frictool.simulate.document_agreement import DocumentNames
    from frictool.verify.recheck import recheck

    plant = _plant(paths.model)
    controller = load(paths.controller, Controller)
    scenario, spec = load(paths.scenario, Scenario), load(paths.spec, Spec)
    same_axis({paths.controller: controller, paths.spec: spec})
    check_requirements(spec, str(paths.spec))
    recheck(controller)
    note_changes(paths.controller, controller)
    controller = with_observer_option(controller, paths.observer)
    names = DocumentNames(str(paths.model), str(paths.controller), str(paths.scenario))
    replay = scenario.reference
    log = None
    if replay is not None:
        from dataclasses import replace

        paths = replace(paths, recorded=paths.scenario.parent / replay.log)
        log = recorded_log(
            paths.scenario.parent / replay.log,
            paths.scenario,
            plant.bench if isinstance(plant, Model) else controller.bench,
        )
    if scenario.variants in ("vertices", "random"):
        note(f"note: the campaign draws plants and ignores variants of {paths.scenario.name}")
    return CampaignSetting(plant, controller, scenario, spec, log, names, number), paths


def commands_of(paths: CampaignPaths, folder: Path, number: ProgramNumber) -> Commands:
    """Return a function that takes a scenario file in `folder` and returns two shell commands.

    Both commands simulate the scenario. The first command names all files without folders, the
    second with the paths that the user typed.
    """
    from frictool.campaign.trials.worst_case import replay_command

    def shown(name: str, show: Callable[[Path], str]) -> str:
        scenario = folder / name
        observer = None if paths.observer is None else show(paths.observer)
        return replay_command(
            show(paths.model),
            show(paths.controller),
            show(scenario),
            observer,
            number,
            show(scenario.with_suffix(".mcap")),
        )

    return lambda name: (
        shown(name, lambda path: path.name),
        shown(name, lambda path: shlex.quote(str(path))),
    )


def header_of(
    trial: TrialPlayer, paths: CampaignPaths, method: str, count: int | None
) -> dict[str, Any]:
    """Return the values that identify a campaign and are stored with its results.

    `count`: number of draws; included only if the draws of `method` depend on this number.
    """
    from frictool import __version__
    from frictool.documents.provenance import digest

    counted = {} if method == "random" else {"number of trials": count}
    settings = {
        "frictool": __version__,
        "code of the metrics": code_digest(PACKAGE),
        "method": method,
        "seed": trial.seed,
        **counted,
        "number": trial.setting.number,
    }
    return settings | {name: digest(path) for name, path in paths.inputs.items()}


def code_digest(package: Path) -> str:
    """Return the SHA-256 of the source files in `package` that compute and judge metrics."""
    sources = [
        package / "documents/metric_table.py",
        *sorted(package.glob("metrics/*.py")),
        *sorted(package.glob("report/*.py")),
    ]
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()


def _plant(path: Path) -> Model | Mechanism:
    from frictool.cli.mechanism_file import load_mechanism
    from frictool.cli.simulate_mechanism import is_mechanism
    from frictool.documents.model import Model
    from frictool.documents.registry import load

    with mechanism_errors_with_line(path):
        return _with_ends(load_mechanism(path)[0]) if is_mechanism(path) else load(path, Model)


@contextmanager
def mechanism_errors_with_line(path: Path) -> Iterator[None]:
    """Replace an ElementError by a DocumentError with the file and line of the element."""
    from frictool.cli.mechanism_file import mechanism_error
    from frictool.plant.mechanism.element_error import ElementError

    try:
        yield
    except ElementError as wrong:
        raise mechanism_error(path, wrong) from None


def _with_ends(document: Mechanism) -> Mechanism:
    from frictool.campaign.trials.trial_player import plant_of

    plant_of(document)
    return document
