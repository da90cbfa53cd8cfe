"""Weights of a design, and rules for missing weights; each derived value names its source.

A is the amplitude of the reference for which the drive is sized: the travel for a position loop,
the top speed for a speed loop. The friction w in [-1, 1] and a reference of 1 rad (speed loop:
1 rad/s) are inputs of equal size. Quantities for a reference of amplitude A are therefore divided
by A:

    W2     bandwidth z2 = 3/(M_mod t_95), twice as large for the speed loop under a position law;
           M_mod, t_95: specified modulus margin and response time; e_stat: specified
           static error, divided by the travel (thesis 5.56, 5.57)
    W1     1/A: full friction leaves an error of e_stat A, the static error of the
           specification. With W1 = 1, as in the thesis, the error is e_stat
    W3     A/(drive's limit): a reference of A does not saturate the drive (thesis 5.58)
    W4     (encoder's step)/A
    W_u    step/(share limit W4): at gamma 1 and any frequency, a signal with the amplitude
           of one count requests at most the fraction `share` of the drive's limit

W1 to W4 weigh friction, error, drive and encoder noise, W_u the command.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from frictool.documents import weights as document
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.spec import Spec
from frictool.documents.synthesis_methods import METHODS
from frictool.errors import FrictoolError
from frictool.plant.generalised_plant import FirstOrderWeight, PlantWeights, template

SETTLING = 3.0  # time constants of a first-order response until 95 %
# W1 A at the start of relax: auto: full friction leaves a hundredth of the static error; the
# thesis has W1 A = 63
STRICTEST = 100.0
# ratio of the bandwidths of speed loop and position law; the thesis has 40 rad/s and 20 rad/s
INNER = 2.0


@dataclass(frozen=True)
class DerivedValue:
    """Value that a rule derives for a key that is missing in the design, with the rule's source."""

    name: str
    value: float
    unit: str
    source: str


@dataclass(frozen=True)
class ChosenWeights:
    """Weights of a design, with data for `relax: auto`, which changes the weights.

    - noise_moves: True if the noise weight was derived from the amplitude A of the reference; the
      noise weight then grows as A falls
    - command_of_noise: product W_u W4 of the weights of command and noise if the weight of the
      command was derived, else None
    - least_effort: smallest allowed factor of W3; with this factor, the noise of one encoder count
      alone reaches the limit of the error weight W2
    """

    weights: PlantWeights
    derived: tuple[DerivedValue, ...]
    noise_moves: bool = False
    command_of_noise: float | None = None
    least_effort: float = 1.0

    def relaxed(self, disturbance: float, effort: float) -> PlantWeights:
        """Return the weights with W1 times `disturbance` and W3 times `effort`, both in (0, 1].

        The amplitude A of the reference, from which other weights are derived, is also multiplied
        by `effort`.
        """
        start = self.weights
        noise = (
            replace(start.noise, gain=start.noise.gain / effort)
            if self.noise_moves
            else start.noise
        )
        command = (
            start.command * effort
            if self.command_of_noise is None
            else self.command_of_noise / noise.gain
        )
        return replace(
            start,
            disturbance=start.disturbance * disturbance,
            drive=start.drive * effort,
            command=command,
            noise=noise,
        )


def choose_weights(model: Model, spec: Spec, design: Design) -> ChosenWeights:
    """Return the weights W1 to W5, W_u and W_eta (plant/generalised_plant.py).

    Raises FrictoolError if a weight is not in the design and does not follow from the
    specification and bench.yaml.
    """
    return _WeightRules(model, spec, design).chosen()


class _WeightRules:
    def __init__(self, model: Model, spec: Spec, design: Design) -> None:
        self.model = model
        self.spec = spec
        self.design = design
        self.provided = design.weights
        self.speed = design.structure != "position"
        self.derived: list[DerivedValue] = []
        self.limit = min(
            quantity.value
            for quantity in (model.bench.actuator.limit, spec.drive_peak)
            if quantity is not None
        )

    def chosen(self) -> ChosenWeights:
        provided = self.provided
        if METHODS[self.design.method].provided_gains and provided == document.Weights():
            self._record_derived(
                "error",
                1.0,
                "",
                "the gains are provided; no weights apply, the norm is the largest sensitivity",
            )
            return ChosenWeights(PlantWeights(FirstOrderWeight(1.0), 0.0, 0.0), tuple(self.derived))
        error = self._template()
        disturbance = self._disturbance()
        drive = self._drive()
        noise = self._noise()
        product = None if provided.command is not None else self._command_of_noise(noise)
        weights = PlantWeights(
            error=error,
            disturbance=disturbance,
            drive=drive,
            command=product / noise if product is not None else provided.command or 0.0,
            noise=_filtered(noise, provided.noise_filter),
            eta=provided.eta,
            uncertainty=FirstOrderWeight(1.0)
            if provided.uncertainty_hz is None
            else decade(1.0, provided.uncertainty_hz),
        )
        least = min(1.0, self._least_amplitude(error) / (drive * self.limit))
        return ChosenWeights(weights, tuple(self.derived), provided.noise is None, product, least)

    def _least_amplitude(self, error: FirstOrderWeight) -> float:
        """Return the amplitude A at which the noise of one count alone reaches the limit of W2.

        A is step/e_stat for a position loop and M_mod z2 step for a speed loop. `step` is the
        encoder step, e_stat the static error, M_mod the modulus margin, and z2 the bandwidth of the
        error weight W2.
        """
        step = self.model.bench.encoder.resolution
        margin = error.gain * error.pole / error.zero
        return margin * error.zero * step if self.speed else error.gain * step

    def _record_derived(self, name: str, value: float, unit: str, source: str) -> float:
        self.derived.append(DerivedValue(f"weights.{name}", value, unit, source))
        return value

    def _template(self) -> FirstOrderWeight:
        provided = self.provided
        spec = self.spec
        travel = self.model.bench.mechanics.travel
        margin, error = provided.modulus_margin, provided.static_error
        bandwidth = provided.bandwidth_rad_s
        if margin is None and spec.modulus_margin is not None:
            margin = self._record_derived(
                "modulus_margin", spec.modulus_margin, "", "modulus_margin of the specification"
            )
        if margin is None:
            raise FrictoolError(
                "modulus_margin: missing in the specification; write it, or "
                "weights.modulus_margin in the design"
            ).at("spec", "modulus_margin")
        if error is None and spec.static_error is not None and travel is not None:
            relative = min(0.5, spec.static_error.value / (travel.high - travel.low))
            error = self._record_derived(
                "static_error",
                relative,
                "",
                "static_error of the specification, divided by mechanics.travel",
            )
        if error is None:
            raise FrictoolError(
                "weights.static_error: missing in the design; write it, or write static_error in "
                "the specification and mechanics.travel in bench.yaml"
            ).at("design", "weights.static_error")
        if bandwidth is None and spec.response_time_95_s is not None:
            value = SETTLING / (margin * spec.response_time_95_s) * (INNER if self.speed else 1.0)
            rule = f"{INNER:g} times 3" if self.speed else "3"
            bandwidth = self._record_derived(
                "bandwidth_rad_s",
                value,
                "rad/s",
                f"{rule}/(modulus_margin response_time_95_s) of the specification",
            )
        if bandwidth is None:
            raise FrictoolError(
                "weights.bandwidth_rad_s: missing in the design; write it, or "
                "response_time_95_s in the specification"
            ).at("design", "weights.bandwidth_rad_s")
        return template(bandwidth, margin, error)

    def _amplitude(self, wanted: str) -> tuple[float, str]:
        """Return the reference's amplitude A, and the key of bench.yaml that states A.

        wanted: key of the missing weight, for an error message.
        """
        mechanics = self.model.bench.mechanics
        if self.speed and mechanics.top_speed is not None:
            return mechanics.top_speed.value, "mechanics.top_speed"
        if not self.speed and mechanics.travel is not None:
            return mechanics.travel.high - mechanics.travel.low, "mechanics.travel"
        missing = "mechanics.top_speed" if self.speed else "mechanics.travel"
        raise FrictoolError(
            f"weights.{wanted}: missing in the design; write it, or {missing} in bench.yaml"
        ).at("design", f"weights.{wanted}")

    def _disturbance(self) -> float:
        if self.provided.disturbance is not None:
            return self.provided.disturbance
        amplitude, source = self._amplitude("disturbance")
        if self.design.relax == "auto":
            return self._record_derived(
                "disturbance",
                STRICTEST / amplitude,
                "",
                f"{STRICTEST:g} divided by {source}, at which relax: auto starts",
            )
        return self._record_derived(
            "disturbance",
            1.0 / amplitude,
            "",
            f"1 divided by {source}: the error under full friction is static_error times {source}",
        )

    def _drive(self) -> float:
        if self.provided.drive is not None:
            return self.provided.drive
        amplitude, source = self._amplitude("drive")
        return self._record_derived(
            "drive",
            amplitude / self.limit,
            "",
            f"{source} divided by the drive's limit {self.limit:g}",
        )

    def _noise(self) -> float:
        if self.provided.noise is not None:
            return self.provided.noise.value
        amplitude, source = self._amplitude("noise")
        step = self.model.bench.encoder.resolution
        return self._record_derived(
            "noise",
            step / amplitude,
            "",
            f"the encoder's step {step:.4g} divided by {source}",
        )

    def _command_of_noise(self, noise: float) -> float:
        """Return the product W_u W4 of the weights of command and noise.

        The product allows one encoder count to change the command by the fraction `count_share` of
        the drive's limit. Raises FrictoolError if the noise weight W4 is 0, since W_u would then be
        infinite.
        """
        if noise <= 0.0:
            raise FrictoolError(
                "weights.command: missing in the design, and weights.noise is 0; write "
                "weights.command (0 for no weight), or raise weights.noise"
            ).at("design", "weights.command")
        step = self.model.bench.encoder.resolution
        share = self.provided.count_share
        product = step / (share * self.limit)
        self._record_derived(
            "command",
            product / noise,
            "",
            f"one encoder count may cause {share:g} times the drive's limit {self.limit:g}",
        )
        return product


def decade(level: float, frequency_hz: float) -> FirstOrderWeight:
    """Return the filter `level` (s/(20 pi f) + 1)/(s/(2 pi f) + 1) of thesis annex C (25), (26).

    The gain falls from `level` to a tenth of `level`. f is `frequency_hz` [Hz].
    """
    return FirstOrderWeight(level, 20.0 * math.pi * frequency_hz, 2.0 * math.pi * frequency_hz)


def _filtered(level: float, dynamics: document.NoiseFilter | None) -> FirstOrderWeight:
    if dynamics is None or level == 0.0:
        return FirstOrderWeight(level)
    printed = decade(level, dynamics.frequency_hz)
    return (
        printed
        if dynamics.reading == "as printed"
        else FirstOrderWeight(level, printed.pole, printed.zero)
    )
