"""Features of a model that a simulator or a drive may be unable to represent."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

from msgspec.structs import replace

from frictool.documents.laws import Laws, Load
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError


@dataclass(frozen=True)
class ModelFeature:
    """Feature that a model may have.

    - text: meaning, for messages
    - present: function that returns True if a model has the feature
    - removed: function that returns a model without the feature
    """

    text: str
    present: Callable[[Model], bool]
    removed: Callable[[Model], Model]


def _laws(model: Model) -> Laws:
    return model.laws or Laws()


def _of_laws(text: str, key: str) -> ModelFeature:
    plain = getattr(Laws(), key)
    return ModelFeature(
        text,
        lambda model: getattr(_laws(model), key) != plain,
        lambda model: replace(model, laws=replace(_laws(model), **{key: plain})),
    )


def _of_load(text: str, key: str) -> ModelFeature:
    plain = getattr(Load(), key)

    def removed(model: Model) -> Model:
        load = replace(_laws(model).load or Load(), **{key: plain})
        return replace(model, laws=replace(_laws(model), load=None if load == Load() else load))

    return ModelFeature(
        text, lambda model: getattr(_laws(model).load or Load(), key) != plain, removed
    )


def _of_model(text: str, key: str) -> ModelFeature:
    return ModelFeature(
        text,
        lambda model: getattr(model, key) is not None,
        lambda model: replace(model, **{key: None}),
    )


def _without_stribeck(model: Model) -> Model:
    parameters = replace(model.parameters, stribeck_velocity=None)
    return replace(model, law=parameters.law, parameters=parameters)


def _has_backlash(model: Model) -> bool:
    backlash = model.bench.mechanics.backlash
    return backlash is not None and backlash.value > 0.0


def _without_backlash(model: Model) -> Model:
    mechanics = replace(model.bench.mechanics, backlash=None, backlash_coulomb=None)
    return replace(model, bench=replace(model.bench, mechanics=mechanics))


FEATURES: dict[str, ModelFeature] = {
    "backward": _of_laws("friction levels of the negative direction", "backward"),
    "regimes": _of_laws("speed-dependent viscous friction", "regimes"),
    "position": _of_laws("position-dependent friction", "position"),
    "stribeck": ModelFeature(
        "fall of the friction with the speed",
        lambda model: model.parameters.stribeck_velocity is not None,
        _without_stribeck,
    ),
    "dwell": _of_laws("breakaway that rises with the time at rest", "dwell"),
    "presliding": _of_model("hysteresis before breakaway", "presliding"),
    "spring": _of_load("spring load", "stiffness"),
    "gravity": _of_load("gravity load", "gravity"),
    "ripple": _of_load("effort ripple", "ripple"),
    "harmonics": _of_load("further harmonics of the effort ripple", "harmonics"),
    "backlash": ModelFeature("backlash of the bench", _has_backlash, _without_backlash),
    "resonances": _of_model("modes of compliant links", "resonances"),
}


def without_features(
    model: Model, target: str, held: Collection[str], without: Collection[str]
) -> tuple[Model, list[str]]:
    """Return the model without the features in `without`, and a line for each removed feature.

    - target: name of the simulator or drive, for the message
    - held: features that the target can represent
    - without: features that the user leaves out

    Raises NoSolutionError if the model has a feature that the target cannot represent and that is
    not in `without`.
    """
    present = [name for name, feature in FEATURES.items() if feature.present(model)]
    refused = [name for name in present if name not in held and name not in without]
    if refused:
        texts = ", ".join(f"{name} ({FEATURES[name].text})" for name in refused)
        options = " ".join(f"--without {name}" for name in refused)
        raise NoSolutionError(
            f"{model.name}: {target} cannot represent {texts}; to omit "
            f"{'it' if len(refused) == 1 else 'them'}, add {options}"
        )
    left_out = [name for name in present if name in without]
    for name in left_out:
        model = FEATURES[name].removed(model)
    return model, [f"left out: {name} ({FEATURES[name].text})" for name in left_out]


def left_out_levels(model: Model, *names: str) -> list[str]:
    """Return a line for each parameter in `names` that the export omits.

    names: `breakaway`, `offset`, or both. A breakaway equal to the Coulomb friction and an offset
    of 0 need no line.
    """
    today, unit = model.parameters, si_unit("effort", model.axis)
    lines = []
    if "breakaway" in names and today.breakaway.value != today.coulomb.value:
        lines.append(
            f"left out: breakaway {today.breakaway.value:.4g} {unit} "
            f"(Coulomb friction {today.coulomb.value:.4g} {unit})"
        )
    if "offset" in names and today.offset.value != 0.0:
        lines.append(f"left out: offset {today.offset.value:.4g} {unit}")
    return lines
