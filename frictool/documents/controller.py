"""`controller.yaml`: the coefficients that run on the target, and the verified loop properties."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Bench, Name, PositiveNumber, SamplePeriod
from frictool.documents.certificate import Certificate, CertifiedWeights
from frictool.documents.design import HELD, Domain, HoldSamples, Scheduled, Structure
from frictool.documents.design_blocks import refuse_overflowing_prefilter
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Axis
from frictool.documents.resonances import Resonances
from frictool.documents.synthesis_methods import StoredMethod

Row = tuple[float, ...]
Number = Literal["double", "float", "q31", "q15"]


class StateSpace(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Matrices of a system with one input and one output, in rows.

    a is n x n, b is n x 1, c is 1 x n, d is 1 x 1.
    """

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
    """Linear controller from eta [rad | m] to the drive [A | V].

    eta is integral(speed reference) - position.

    `discrete`: x[k+1] = a x[k] + b eta[k], drive[k] = c x[k] + d eta[k], at the sample period.
    `continuous`: its inverse Tustin transform.

    `sos`: the same as second-order sections b0 b1 b2 a0 a1 a2 with a0 = 1, H = (b0 + b1/z +
    b2/z^2)/(1 + a1/z + a2/z^2). `form` selects the realisation that runs on the target. Sections
    run in transposed direct form II; `sos_anti_windup` holds the anti-windup gains of their states.

    `anti_windup`: the gains l in x[k+1] = a x + b eta + l (limited drive - drive).

    `input`: `speed_error` feeds speed reference - speed instead of eta (a PI controller of the
    speed). In structure `position` the input is always the filtered reference minus the position.

    `conditional`: an integrator state is one whose row of `a` is that of the identity. These states
    are held while the drive is limited and their input would move them further into the limit. They
    are also held in the band of a position law while the drive is 0; without this option they are
    reset there.
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
                f"anti_windup has {len(self.anti_windup)} gains; allowed: "
                f"{len(self.discrete.a)}, one for each state"
            )
        for index, row in enumerate(self.sos):
            if len(row) != 6 or row[3] != 1.0:
                raise ValueError(
                    f"sos[{index}]: found {list(row)}; allowed: b0, b1, b2, a0, a1, a2 with a0 = 1"
                )
        if self.form == "sos" and len(self.sos_anti_windup) != 2 * len(self.sos):
            raise ValueError(
                f"sos_anti_windup has {len(self.sos_anti_windup)} gains; allowed: "
                f"{2 * len(self.sos)}, two for each section"
            )


class PositionLaw(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Speed reference as a function of the position error e, and the action inside |e| <= band.

    `kind`: `square_root`, gain sqrt(|e|) sign(e) (5.19), or `proportional`, gain e. The gain is in
    position^(1/2)/s or in 1/s. `formula`: the formula of a square-root law's gain.

    `action`: `cut` opens the loop inside the band; `brake` does so only below `rest_speed`; `none`
    never does. `settled_speed`: `cut` and `brake` wait until the prefilter moves more slowly than
    this.
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
                "action brake needs rest_speed > 0: no measured speed is below 0, the "
                "drive would never be cut"
            )
        if self.band == 0.0 and (self.kind == "square_root" or self.action != "none"):
            raise ValueError(
                "a square-root law, cut and brake need band > 0: below it the root is "
                "continued by a straight line"
            )


class Velocity(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Source of the speed signal for the nonlinear blocks.

    `source`: `measured` is a speed sensor, `observer` estimates the speed from position and drive,
    and `position` is the difference of the encoder position through a low-pass discretised by
    Tustin.

    `order` 1 is bandwidth/(s + bandwidth), `order` 2 is (5.70). `bandwidth_rad_s` 0 means no
    low-pass. `observer` is a complete observer.yaml.
    """

    source: Literal["position", "measured", "observer"] = "position"
    order: Literal[1, 2] = 1
    bandwidth_rad_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    observer: Observer | None = None

    def __post_init__(self) -> None:
        if (self.source == "observer") != (self.observer is not None):
            raise ValueError("source observer needs an observer, and no other source has one")


class Limiter(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Release of the drive near the target (5.2.2), for structure `position`.

    The integrator is frozen while the drive is released.

    `condition`: the drive is released for `energy` if ||e| - inertia v^2/(2 (coulomb +
    virtual_coulomb))| < band (5.7), (5.40), and for `error` if |e| < band, the usual cut-off that
    5.2.1 argues against.

    `virtual_coulomb`: a released drive applies the effort -virtual_coulomb tanh(v/virtual_speed)
    (5.41), in N m | N and rad/s | m/s. `settled_speed`: the release waits until the prefilter moves
    more slowly than this.
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
    """Friction effort [N m | N], modelled or observed, that is added to the drive.

    This is the baseline that 5.1 argues against. `source` `model`: coulomb tanh(v/smoothing_speed)
    + viscous v, with the speed v of the filtered reference or the measured speed. `source`
    `observer`: the disturbance that an observer of bandwidth `observer_rad_s` estimates from drive,
    measured speed and inertia. `gain`: fraction of the effort that is added.
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
                "source model needs smoothing_speed: the speed below which the "
                "modelled friction fades"
            )
        if self.source == "observer" and (self.observer_rad_s == 0.0 or self.inertia == 0.0):
            raise ValueError("source observer needs observer_rad_s and inertia")


class Prefilter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Second-order low-pass filter of the reference (5.69)."""

    natural_frequency_rad_s: PositiveNumber
    damping: PositiveNumber

    def __post_init__(self) -> None:
        refuse_overflowing_prefilter(self.natural_frequency_rad_s, self.damping)


class DelayCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Sampled loop at one vertex with `delay_samples` samples of computational delay."""

    delay_samples: int
    spectral_radius: float
    modulus_margin: float


class Vertex(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One vertex of the polytope: its parameters (SI), and properties of the closed loop there.

    `norm`: from the weighted inputs to the weighted outputs, in the design domain. `sampled_norm`:
    the same norm of the sampled loop.
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
    """Worst margins of the sampled loop over the vertices; None if a margin is unlimited.

    The loop has the bench's computational delay.

    `gain_increase`, `gain_decrease`: admissible factors on the loop gain. `phase_deg` [degrees],
    `delay_s` [s]: admissible additional phase lag and delay. `small_gain`: annex (27), the norm
    from the friction in [-1, 1] to the speed [rad/s | m/s].
    """

    small_gain: float
    gain_increase: float | None = None
    gain_decrease: float | None = None
    phase_deg: float | None = None
    delay_s: float | None = None


class Robustness(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Worst norm of the sampled loop over the whole box: samples and upper bounds.

    A bound is None if none could be proved.

    `interior`: the largest norm at `interior_points` plants inside the box and along a search
    uphill from the worst vertex; a lower bound. `structured`: upper bound for every constant plant,
    from D-G scalings. `parameter_dependent`: upper bound from a Lyapunov matrix that varies with
    constant parameters. `common`: upper bound from one Lyapunov matrix, for parameters that vary
    arbitrarily fast. The last two hold for interpolations of the corners' sampled models.
    """

    interior_points: int
    interior: float
    structured: float | None = None
    parameter_dependent: float | None = None
    common: float | None = None


class Rounded(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Loop properties with the coefficients rounded to a number format of the target."""

    number: Number
    gamma: float
    modulus_margin: float


class Verified(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Verified properties of the loop.

    `gamma_asked`: bound that the method claims for its own plants, if it has one. `gamma_verified`:
    worst norm of the rebuilt sampled loop. `count_drive`: largest drive after one encoder count [A
    | V]. `digests`: SHA-256 of each block at verification (digests.py).
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
    """Controller at one corner of the scheduled parameters, in coordinates common to all corners.

    The parameters that are not scheduled have their centre values. `anti_windup`: gains in these
    coordinates, summed with the same weights; they differ from those of the frozen controller.
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
                f"anti_windup has {len(self.anti_windup)} gains; allowed: "
                f"{len(self.discrete.a)}, one for each state"
            )


class Schedule(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Gain schedule for parameters that are known at run time.

    The corners' matrices are summed with the weights (5.46) of the plant (5.64).

    `parameters`: the scheduled parameters. `gamma`: worst norm of the sampled loop over the corners
    and `points` plants between them, each with the controller of its own parameters.
    `modulus_margin`: the worst modulus margin of these plants.
    """

    parameters: tuple[Scheduled, ...]
    corners: tuple[Corner, ...]
    gamma: float
    modulus_margin: float
    points: int


class Controller(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`controller.yaml`.

    `method` `own` means an external design (synth/external_controller.py).

    `measurement_hold_samples`: an invalid input (NaN) is replaced by its last valid value for at
    most this number of samples in a row. Then the drive becomes 0 and the fault is set
    (docs/theory/export.md).

    `weights`: weights of the generalised plant whose norm was verified, if no certificate holds
    them.

    `resonances`: of the model. Stability and the modulus margin at the vertices hold with them;
    norms and certificate are those of the plant without them.
    """

    format: Literal["controller/1"]
    name: Name
    axis: Axis
    structure: Structure
    method: StoredMethod
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
        """Return the weights of the verified norm; None if a speed is the input of the loop.

        They are those of the certificate, or else `weights`.
        """
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
