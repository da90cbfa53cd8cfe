"""What `frictool campaign` is given: the documents, loaded and held against each other, and what varies."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictool.cli.output import note

if TYPE_CHECKING:
    from frictool.campaign.space import Space
    from frictool.cli.campaign_trial import CampaignTrial, Setting
    from frictool.documents.controller import Number
    from frictool.documents.mechanism import Mechanism
    from frictool.documents.model import Model
    from frictool.documents.spec import Spec


@dataclass(frozen=True)
class Paths:
    """The inputs of a campaign; recorded: the log that the scenario replays."""

    model: Path
    controller: Path
    scenario: Path
    spec: Path
    observer: Path | None
    recorded: Path | None = None

    @property
    def inputs(self) -> dict[str, Path]:
        """Those that there are, by what they are."""
        return {name: path for name, path in vars(self).items() if path is not None}


def setting_of(paths: Paths, number: Number) -> tuple[Setting, Paths]:
    """The documents, and the paths with the log that is replayed. Raises InputFileError where they do not fit together."""
    from frictool.cli.campaign_trial import Setting
    from frictool.cli.simulate import observed_controller, recorded_log
    from frictool.documents.controller import Controller
    from frictool.documents.model import Model
    from frictool.documents.registry import load, same_axis
    from frictool.documents.scenario import Scenario
    from frictool.documents.spec import Spec
    from frictool.simulate.agreement import Names
    from frictool.verify.controller import recheck

    plant, controller = _plant(paths.model), load(paths.controller, Controller)
    scenario, spec = load(paths.scenario, Scenario), load(paths.spec, Spec)
    same_axis({paths.controller: controller, paths.spec: spec})
    _asks(paths.spec, spec)
    recheck(controller)
    controller = observed_controller(controller, paths.observer)
    names = Names(str(paths.model), str(paths.controller), str(paths.scenario))
    replay, log = scenario.reference, None
    if replay is not None:
        from dataclasses import replace

        paths = replace(paths, recorded=paths.scenario.parent / replay.log)
        log = recorded_log(
            paths.scenario.parent / replay.log, paths.scenario, plant.bench if isinstance(plant, Model) else controller.bench
        )
    if scenario.variants in ("vertices", "random"):
        note(f"note: variants of {paths.scenario.name} are left out: a campaign draws its own plants")
    return Setting(plant, controller, scenario, spec, log, names, number), paths


def space_of_setting(setting: Setting) -> Space:
    """What varies. Raises DocumentError where `spread` does not fit the plant or the scenario, or nothing varies."""
    from msgspec.structs import replace

    from frictool.campaign.drawn import nominal_of
    from frictool.campaign.space import plant_factors, space_of
    from frictool.campaign.spreading import spread_factors
    from frictool.cli.campaign_trial import plant_of
    from frictool.documents.spread import Spread
    from frictool.simulate.agreement import refuse
    from frictool.simulate.spread_checks import check_spread
    from frictool.simulate.step_test import StepTest

    plant, scenario = plant_of(setting.plant), setting.scenario
    reference, _ = StepTest(plant, setting.controller, setting.names).reference(nominal_of(scenario), setting.recorded)
    plant.check(setting.controller, replace(nominal_of(scenario), spread=scenario.spread), setting.names)  # the blocks that it names
    check_spread(plant, scenario, reference.size * plant.rig.sample_period_s, setting.names)
    spread = scenario.spread or Spread()
    space = space_of([*plant_factors(plant.ranges(), spread.parameters), *spread_factors(scenario)])
    if not space.factors:
        message = (
            f"nothing varies: {setting.names.model} has no ranges; write spread, or low and high beside the values of bench or mechanism"
        )
        refuse(setting.names.scenario, "spread", message)
    return space


def header_of(trial: CampaignTrial, paths: Paths, method: str, count: int | None) -> dict[str, Any]:
    """What makes a campaign another one. count: of draws, where they depend on it."""
    from frictool import __version__
    from frictool.documents.provenance import digest

    counted = {} if method == "random" else {"number of trials": count}
    settings = {"frictool": __version__, "method": method, "seed": trial.seed, **counted, "number": trial.setting.number}
    return settings | {name: digest(path) for name, path in paths.inputs.items()}


def _plant(path: Path) -> Model | Mechanism:
    from frictool.cli.mechanism_file import load_mechanism
    from frictool.cli.simulate_mechanism import is_mechanism
    from frictool.documents.model import Model
    from frictool.documents.registry import load

    with told_by_line(path):
        return _with_ends(load_mechanism(path)[0]) if is_mechanism(path) else load(path, Model)


@contextmanager
def told_by_line(path: Path) -> Iterator[None]:
    """Complaints of a mechanism's element with its file and line."""
    from frictool.cli.mechanism_file import wrong_in_file
    from frictool.plant.mechanism.wrong import WrongElement

    try:
        yield
    except WrongElement as wrong:
        raise wrong_in_file(path, wrong) from None


def _with_ends(document: Mechanism) -> Mechanism:
    """The mechanism, of which a controller can see and drive something. Raises WrongElement where it cannot."""
    from frictool.cli.campaign_trial import plant_of

    plant_of(document)
    return document


def _asks(path: Path, spec: Spec) -> None:
    """Raises DocumentError where the specification asks for nothing that a run can tell."""
    from frictool.documents.spec import Spec
    from frictool.errors import DocumentError

    asked = [name for name in Spec.__struct_fields__ if name not in ("format", "name", "axis", "drive")]
    if all(getattr(spec, name) is None for name in asked if name != "modulus_margin"):
        listed = ", ".join(name for name in asked if name != "modulus_margin")
        raise DocumentError(path, f"asks for nothing that a run can tell; write at least one of {listed}", line=None, key="")
