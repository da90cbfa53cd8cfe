"""`controller.yaml`: the coefficients that run on the target, and what was verified of the loop
that they close."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Bench, Name, PositiveNumber, SamplePeriod
from frictool.documents.certificate import Certificate, CertifiedWeights
from frictool.documents.design import HELD, Domain, HoldSamples, Method, Scheduled, Structure
from frictool.documents.design_blocks import refuse_overflowing_prefilter
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Axis
from frictool.documents.resonances import Resonances

Row = tuple[float, ...]
Number = Literal["double", "float", "q31", "q15"]


class StateSpace(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Matrices in rows; one input, one output: a is n x n, b is n x 1, c is 1 x n, d is 1 x 1."""

    a: tuple[Row, ...]
    b: tuple[Row, ...]
    c: tuple[Row, ...]
    d: tuple[Row, ...]

    def __post_init__(self) -> None:
        n = len(self.a)
        shapes = (
            all(len(row) == n for row in self.a),
            len(self.b) == n and all(len(row) == 1 for row in self.b),
            len(self.c) == 1 and len(self.c[0]) == n,
            len(self.d) == 1 and len(self.d[0]) == 1,
        )
        if not all(shapes):
            raise ValueError(
                f"matrices do not fit together; allowed: a {n}x{n}, b {n}x1, c 1x{n}, d 1x1"
            )


class LinearController(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """From eta = integral(speed reference) - position [rad or m] to the drive [A or V].

    discrete: x[k+1] = a x[k] + b eta[k], drive[k] = c x[k] + d eta[k], at the sample period.
    continuous: its inverse Tustin image. sos: the same as second-order sections b0 b1 b2 a0 a1 a2,
    a0 = 1, H = (b0 + b1/z + b2/z^2)/(1 + a1/z + a2/z^2). anti_windup: l in x[k+1] = a x + b eta + l
    (limited drive - drive). input: what enters it in place of eta; speed_error is speed reference -
    speed (a PI of the speed). In structure position it is the filtered reference less the position,
    whatever is said here. form: which of both runs on the target. Sections run in the transposed
    direct form II, the anti-windup gains of their states are sos_anti_windup. conditional: the
    states that are integrators (their row of `a` is that of the identity) are held while the drive
    is limited and what enters would move them further, and in the band of a position law where the
    drive is 0 (without, they are reset there).
    """

    discrete: StateSpace
    continuous: StateSpace
    sos: tuple[Row, ...]
    anti_windup: tuple[float, ...]
    input: Literal["eta", "speed_error"] = "eta"
    form: Literal["state_space", "sos"] = "state_space"
    sos_anti_windup: tuple[float, ...] = ()
    conditional: bool = False

    def __post_init__(self) -> None:
        if len(self.anti_windup) != len(self.discrete.a):
            raise ValueError(
                f"anti_windup has {len(self.anti_windup)} gains; allowed: {len(self.discrete.a)}, one for each state"
            )
        for index, row in enumerate(self.sos):
            if len(row) != 6 or row[3] != 1.0:
                raise ValueError(
                    f"sos[{index}]: found {list(row)}; allowed: b0, b1, b2, a0, a1, a2 with a0 = 1"
                )
        if self.form == "sos" and len(self.sos_anti_windup) != 2 * len(self.sos):
            raise ValueError(
                f"sos_anti_windup has {len(self.sos_anti_windup)} gains; allowed: {2 * len(self.sos)}, two for each section"
            )


class PositionLaw(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The speed reference from the position error e, and what happens inside the band |e| <= band.

    kind: square_root, gain sqrt(|e|) sign(e) (5.19), or proportional, gain e. Units of gain:
    position^(1/2)/s, or 1/s. action: cut opens the loop inside the band, brake does so below
    rest_speed, none never does. settled_speed: of the prefilter, for which both wait. formula: of a
    square-root law's gain.
    """

    gain: PositiveNumber
    kind: Literal["square_root", "proportional"] = "square_root"
    formula: Literal["sqrt(2F/J)", "sqrt(F/J)"] | None = None
    band: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    action: Literal["cut", "brake", "none"] = "none"
    settled_speed: PositiveNumber | None = None
    rest_speed: Annotated[float, msgspec.Meta(ge=0)] = 0.0

    def __post_init__(self) -> None:
        if self.action == "brake" and self.rest_speed == 0.0:
            raise ValueError(
                "action brake needs rest_speed > 0: no measured speed is below 0, the drive would never be cut"
            )
        if self.band == 0.0 and (self.kind == "square_root" or self.action != "none"):
            raise ValueError(
                "a square-root law, cut and brake need band > 0: below it the root is continued by a straight line"
            )


class Velocity(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The speed that the blocks see: `measured` by a sensor of its own, what an `observer` finds
    from position and drive, or the encoder's difference through a low-pass sampled by Tustin.

    order 1: bandwidth/(s + bandwidth). order 2: (5.70). bandwidth_rad_s 0: the difference itself.
    observer: observer.yaml, whole.
    """

    source: Literal["position", "measured", "observer"] = "position"
    order: Literal[1, 2] = 1
    bandwidth_rad_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    observer: Observer | None = None

    def __post_init__(self) -> None:
        if (self.source == "observer") != (self.observer is not None):
            raise ValueError("source observer needs an observer, and no other source has one")


class Limiter(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Of structure position: where the drive is released (5.2.2). The integrator is frozen
    meanwhile.

    condition: energy, ||e| - inertia v^2/(2 (coulomb + virtual_coulomb))| < band (5.7), (5.40);
    error, |e| < band, the usual cut-off that 5.2.1 argues against. virtual_coulomb: the effort
    -virtual_coulomb tanh(v/virtual_speed) acts there (5.41), in N m | N and rad/s | m/s.
    settled_speed: of the prefilter, for which the release waits.
    """

    condition: Literal["energy", "error"]
    band: PositiveNumber
    inertia: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    coulomb: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    virtual_coulomb: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    virtual_speed: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    settled_speed: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if self.condition == "energy" and (
            self.inertia == 0.0 or self.coulomb + self.virtual_coulomb == 0.0
        ):
            raise ValueError("condition energy needs inertia and coulomb (5.7)")
        if self.virtual_coulomb > 0.0 and self.virtual_speed == 0.0:
            raise ValueError("virtual_coulomb needs virtual_speed (5.41)")


class FrictionCompensation(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """The baseline that 5.1 argues against: friction's effort [N m | N], modelled or observed,
    added to the drive.

    source model: coulomb tanh(v/smoothing_speed) + viscous v, v the filtered reference's speed or
    the measured one. source observer: the disturbance that an observer of bandwidth observer_rad_s
    finds from drive, measured speed and inertia. gain: the part that is added.
    """

    source: Literal["model", "observer"]
    velocity: Literal["reference", "measured"] = "measured"
    coulomb: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    viscous: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    smoothing_speed: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    observer_rad_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    inertia: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    gain: Annotated[float, msgspec.Meta(gt=0, le=1.5)] = 1.0

    def __post_init__(self) -> None:
        if self.source == "model" and self.smoothing_speed == 0.0:
            raise ValueError(
                "source model needs smoothing_speed: the speed below which the modelled friction fades"
            )
        if self.source == "observer" and (self.observer_rad_s == 0.0 or self.inertia == 0.0):
            raise ValueError("source observer needs observer_rad_s and inertia")


class Prefilter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Second-order low-pass of the reference (5.69)."""

    natural_frequency_rad_s: PositiveNumber
    damping: PositiveNumber

    def __post_init__(self) -> None:
        refuse_overflowing_prefilter(self.natural_frequency_rad_s, self.damping)


class DelayCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The sampled loop at one vertex with `delay_samples` samples of computational delay."""

    delay_samples: int
    spectral_radius: float
    modulus_margin: float


class Vertex(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One vertex of the polytope: its parameters in SI, and the closed loop there.

    norm: from the weighted inputs to the weighted outputs, in the domain that the controller was
    designed in; sampled_norm: as it runs.
    """

    name: str
    inertia: float
    viscous: float
    coulomb: float
    constant: float
    norm: float
    sampled_norm: float
    modulus_margin: float
    stable: bool
    checks: tuple[DelayCheck, ...]


class Margins(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The worst of each over the vertices, of the sampled loop with the bench's delay; None where
    nothing limits it.

    gain_increase, gain_decrease: factors on the loop gain that it stands. phase_deg [degrees],
    delay_s [s]: lag and delay that it stands beside its own. small_gain: annex (27), the norm from
    the friction in [-1, 1] to the speed [rad/s or m/s].
    """

    small_gain: float
    gain_increase: float | None = None
    gain_decrease: float | None = None
    phase_deg: float | None = None
    delay_s: float | None = None


class Robustness(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The worst norm of the sampled loop over the whole box, seen and bounded; None where no bound
    was found.

    interior: the largest of `interior_points` plants inside and of a search uphill from the worst
    vertex; a lower bound. structured: for every constant plant, by D-G scalings.
    parameter_dependent: by a Lyapunov matrix that moves with the parameters, these constant.
    common: by one Lyapunov matrix, the parameters as fast as they like. The last two are of the
    plants between the corners' samples.
    """

    interior_points: int
    interior: float
    structured: float | None = None
    parameter_dependent: float | None = None
    common: float | None = None


class Rounded(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The loop again with the coefficients rounded to a number format of the target."""

    number: Number
    gamma: float
    modulus_margin: float


class Verified(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """gamma_asked: bound of the method on its own plants, where it has one. gamma_verified: worst
    norm of the rebuilt sampled loop.

    count_drive: the largest drive after one encoder count [A or V]. digests: SHA-256 of each block
    as it was verified (digests.py).
    """

    gamma_asked: float | None
    gamma_verified: float
    modulus_margin_specified: float
    vertices: tuple[Vertex, ...]
    count_drive: float | None = None
    rounded: tuple[Rounded, ...] = ()
    margins: Margins | None = None
    robustness: Robustness | None = None
    digests: dict[str, str] = {}


class Corner(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The controller at one corner of the scheduled parameters, the others being the centre's, in
    coordinates common to all corners.

    anti_windup: its gains in those coordinates, summed with the same weights; they are not those of
    the frozen controller.
    """

    inertia: float
    viscous: float
    coulomb: float
    constant: float
    discrete: StateSpace
    anti_windup: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.anti_windup) != len(self.discrete.a):
            raise ValueError(
                f"anti_windup has {len(self.anti_windup)} gains; allowed: {len(self.discrete.a)}, one for each state"
            )


class Schedule(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the parameters are known while it runs: the corners' matrices summed with the weights
    (5.46) of the plant (5.64).

    parameters: those that are scheduled. gamma: worst norm of the sampled loop over the corners and
    `points` plants between them, each with the controller of its own parameters; modulus_margin:
    the worst one there.
    """

    parameters: tuple[Scheduled, ...]
    corners: tuple[Corner, ...]
    gamma: float
    modulus_margin: float
    points: int


class Controller(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`controller.yaml`.

    method own: designed by somebody else (synth/external_controller.py).
    measurement_hold_samples: number of samples in a row for which an invalid input (NaN) keeps its
    last valid value; then the drive is 0 and the fault is set (docs/theory/export.md). weights: of
    the generalised plant whose norm was verified, where no certificate holds them. resonances: of
    the model, with which stability and the modulus margin hold at the vertices too; norms and
    certificate are of the plant without them.
    """

    format: Literal["controller/1"]
    name: Name
    axis: Axis
    structure: Structure
    method: Literal[Method, "own"]
    domain: Domain
    sample_period_s: SamplePeriod
    delay_samples: Annotated[int, msgspec.Meta(ge=0, le=2)]
    drive: Literal["current", "voltage"]
    drive_limit: PositiveNumber
    sign_convention: str
    linear: LinearController
    verified: Verified
    bench: Bench
    provenance: Provenance
    position_law: PositionLaw | None = None
    prefilter: Prefilter | None = None
    velocity: Velocity = Velocity()
    limiter: Limiter | None = None
    friction_compensation: FrictionCompensation | None = None
    certificate: Certificate | None = None
    weights: CertifiedWeights | None = None
    schedule: Schedule | None = None
    resonances: Resonances | None = None
    measurement_hold_samples: HoldSamples = HELD

    @property
    def judged_by(self) -> CertifiedWeights | None:
        """The weights of its norm: the certificate's, or those beside `verified`; a loop that is
        fed by a speed is weighed by none."""
        if self.linear.input == "speed_error":
            return None
        return self.certificate.weights if self.certificate is not None else self.weights

    def __post_init__(self) -> None:
        cascade = self.structure == "speed_cascade"
        if cascade != (self.position_law is not None):
            raise ValueError(
                "structure speed_cascade has a position_law, structure position has none"
            )
        if cascade and self.limiter is not None:
            raise ValueError(
                "limiter is for structure position: in a cascade position_law.action does its work"
            )
