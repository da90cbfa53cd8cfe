"""`controller.yaml`: coefficients for the target hardware, and verified properties of the loop."""

from __future__ import annotations

import itertools
from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Bench, Name, PositiveNumber, SamplePeriod
from frictool.documents.certificate import Certificate, CertifiedWeights
from frictool.documents.design import (
    DEFAULT_HOLD_SAMPLES,
    Domain,
    HoldSamples,
    Scheduled,
    Structure,
)
from frictool.documents.design_blocks import SmoothingSamples, refuse_overflowing_prefilter
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Axis, PositionSpan, StiffnessEstimate
from frictool.documents.resonances import Resonances, Ringing
from frictool.documents.synthesis_methods import StoredMethod
from frictool.runtime.object_view import ObjectView

Row = tuple[float, ...]
Number = Literal["double", "float", "q31", "q15"]  # number format of coefficients
ProgramNumber = Literal["double", "float", "q31"]  # number format of a program


class StateSpace(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Matrices of a system with one input and one output, as lists of rows.

    - `a`: State matrix, n x n.
    - `b`: Input matrix, n x 1.
    - `c`: Output matrix, 1 x n.
    - `d`: Direct gain, 1 x 1.
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
    """Linear controller, whose input is eta [rad | m] and whose output is the drive [A | V].

    In structure `position`, eta is the filtered reference minus the position. In structure
    `speed_cascade`, eta is the integral of the speed reference, minus the position.

    - `discrete`: Controller at the sample period: x[k+1] = a x[k] + b eta[k], drive[k] = c x[k] + d
      eta[k].
    - `continuous`: Inverse Tustin transform of `discrete`.
    - `sos`: `discrete` as second-order sections b0 b1 b2 a0 a1 a2 with a0 = 1: H = (b0 + b1/z +
      b2/z^2)/(1 + a1/z + a2/z^2).
    - `anti_windup`: Gains l in x[k+1] = a x + b eta + l (limited drive - drive).
    - `input`: Input of the linear controller: `eta`, or for a PI controller of the speed
      `speed_error` (speed reference minus speed).
    - `form`: Form of the difference equation that runs on the target hardware: the matrices
      `discrete` with `anti_windup`, or the second-order sections `sos` with `sos_anti_windup`.
      Sections run in transposed direct form II.
    - `sos_anti_windup`: Anti-windup gains of the sections' states, in the order of `sos`.
    - `conditional`: True for conditional integration. An integrator state then keeps its value in
      two cases: the drive is limited and the integrator would increase the excess, or the position
      law switches the drive off. If the key is false, the position law sets the state to 0 when it
      switches the drive off.
    """

    discrete: StateSpace
    continuous: StateSpace
    sos: tuple[Row, ...]
    anti_windup: tuple[float, ...]
    input: Literal["eta", "speed_error"] = "eta"
    form: Literal["state_space", "sos"] = "state_space"
    sos_anti_windup: tuple[float, ...] = ()
    conditional: bool = False

    @property
    def order(self) -> int:
        """Return the number of states."""
        return len(self.discrete.a)

    def __post_init__(self) -> None:
        if len(self.anti_windup) != self.order:
            raise ValueError(
                f"anti_windup has {len(self.anti_windup)} gains; allowed: "
                f"{self.order}, one for each state"
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
    """Speed reference as a function of the position error e, and the action inside the rest band.

    The rest band is the range |e| <= `band` around the target.

    - `gain`: Gain of the law: [rad^0.5/s | m^0.5/s] for a square-root law, [1/s] for a proportional
      law.
    - `kind`: Form of the law. `square_root`: the speed reference is `gain` sqrt(|e|) sign(e).
      `proportional`: the speed reference is `gain` e.
    - `formula`: Formula of the gain of a square-root law, with Coulomb friction F and inertia J.
    - `band`: Half-width of the rest band [rad | m].
    - `action`: `cut` switches the drive off inside the rest band. `brake` switches the drive off
      inside the rest band only when the measured speed is below `rest_speed`. `none` never switches
      the drive off.
    - `settled_speed`: `cut` and `brake` act only if the speed of the prefilter is below this value
      [rad/s | m/s].
    - `rest_speed`: Measured speed below which `brake` switches the drive off [rad/s | m/s].
    """

    # (5.19)
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
                "`action: brake` needs rest_speed > 0; otherwise the drive is never switched off"
            )
        if self.band == 0.0 and (self.kind == "square_root" or self.action != "none"):
            raise ValueError("a square-root law and the actions cut and brake need `band` > 0")


class Velocity(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Source of the speed signal for the nonlinear blocks.

    - `source`: Source of the speed. `position`: the speed is computed from differences of the
      encoder position by a low-pass filter, which is discretised by Tustin's rule. `measured`: a
      speed sensor measures the speed. `observer`: an observer estimates the speed from position and
      drive.
    - `order`: Order of the low-pass filter; order 1 is bandwidth/(s + bandwidth).
    - `bandwidth_rad_s`: Bandwidth of the low-pass filter; 0 for unfiltered differences.
    - `observer`: Observer with the keys of observer.yaml. The command `observe loop` writes this
      key.
    """

    # order 2 is (5.70)
    source: Literal["position", "measured", "observer"] = "position"
    order: Literal[1, 2] = 1
    bandwidth_rad_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    observer: Observer | None = None

    def __post_init__(self) -> None:
        if (self.source == "observer") != (self.observer is not None):
            raise ValueError(
                "`observer`: required with `source: observer`, allowed with no other source"
            )


class Limiter(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Block that switches the drive off near the target (structure `position`).

    The integrator keeps its value while the drive is off. The rest band is the range of position
    errors up to `band`.

    - `condition`: Condition for switching the drive off, with position error e and speed v.
      `energy`: ||e| - inertia v^2/(2 (coulomb + virtual_coulomb))| < band. `error`: |e| < band.
    - `band`: Half-width of the rest band [rad | m].
    - `inertia`: Inertia in condition `energy` [kg m^2 | kg].
    - `coulomb`: Coulomb friction in condition `energy` [N m | N].
    - `virtual_coulomb`: Largest braking effort [N m | N] while the drive is otherwise off. The
      effort is -virtual_coulomb tanh(v/virtual_speed).
    - `virtual_speed`: Speed scale of the braking effort [rad/s | m/s].
    - `settled_speed`: The drive is switched off only if the speed of the prefilter is below this
      value [rad/s | m/s].
    """

    # 5.2.2: (5.7), (5.40), (5.41); error is the usual cut-off that 5.2.1 argues against
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
            raise ValueError("`condition: energy` needs `inertia` and `coulomb`")
        if self.virtual_coulomb > 0.0 and self.virtual_speed == 0.0:
            raise ValueError("virtual_coulomb needs virtual_speed")


class FrictionCompensation(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Friction effort that is added to the drive, as a baseline for comparison.

    - `source`: Source of the effort. `model`: the effort is coulomb tanh(v/smoothing_speed) +
      viscous v, or it is interpolated in the table `speeds`, `efforts`. `observer`: the effort is
      the disturbance that an observer estimates from drive, measured speed and inertia.
    - `velocity`: Origin of the speed v: the filtered reference, or the measured speed.
    - `coulomb`: Coulomb friction of the model [N m | N].
    - `viscous`: Viscous friction of the model [N m s/rad | N s/m].
    - `smoothing_speed`: Speed scale below which the modelled friction decreases to 0 [rad/s | m/s].
    - `speeds`: Rising signed speeds of a table [rad/s | m/s]; beyond the ends of the table, the
      friction is extrapolated linearly.
    - `efforts`: Friction at each speed of the table [N m | N].
    - `positions`: Rising positions [rad | m] of a table of additional friction; beyond the table,
      this friction is constant.
    - `forward`: Coulomb friction at each position, minus the mean Coulomb friction, in the positive
      direction [N m | N].
    - `backward`: Coulomb friction at each position, minus the mean Coulomb friction, in the
      negative direction [N m | N]. The default is `forward`.
    - `observer_rad_s`: Bandwidth of the observer.
    - `inertia`: Inertia of the observer [kg m^2 | kg].
    - `gain`: Fraction of the friction effort that is added to the drive.
    """

    # 5.1 argues against it
    source: Literal["model", "observer"]
    velocity: Literal["reference", "measured"] = "measured"
    coulomb: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    viscous: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    smoothing_speed: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    speeds: tuple[float, ...] = ()
    efforts: tuple[float, ...] = ()
    positions: tuple[float, ...] = ()
    forward: tuple[float, ...] = ()
    backward: tuple[float, ...] = ()
    observer_rad_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    inertia: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    gain: Annotated[float, msgspec.Meta(gt=0, le=1.5)] = 1.0

    def __post_init__(self) -> None:
        if self.source == "model" and self.smoothing_speed == 0.0:
            raise ValueError(
                "`source: model` needs smoothing_speed, the speed below which the "
                "modelled friction decreases to 0"
            )
        if self.source == "observer" and (self.observer_rad_s == 0.0 or self.inertia == 0.0):
            raise ValueError("`source: observer` needs observer_rad_s and inertia")
        _check_table("speeds", self.speeds, "efforts", self.efforts)
        _check_table("positions", self.positions, "forward", self.forward)
        if self.backward:
            _check_table("positions", self.positions, "backward", self.backward)


def _check_table(
    points_name: str, points: tuple[float, ...], values_name: str, values: tuple[float, ...]
) -> None:
    if len(points) != len(values) or len(points) == 1:
        raise ValueError(
            f"{points_name} and {values_name}: found {len(points)} and {len(values)} values; "
            "allowed: equal numbers, at least 2"
        )
    if any(low >= high for low, high in itertools.pairwise(points)):
        raise ValueError(f"{points_name}: not in rising order; sort the table")


class Prefilter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Second-order low-pass filter of the reference.

    - `natural_frequency_rad_s`: Natural frequency of the filter.
    - `damping`: Damping ratio of the filter.
    """

    # (5.69)
    natural_frequency_rad_s: PositiveNumber
    damping: PositiveNumber

    def __post_init__(self) -> None:
        refuse_overflowing_prefilter(self.natural_frequency_rad_s, self.damping)


class Profile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Profile with bounded jerk from the present position to the reference.

    - `speed`: Largest speed [rad/s | m/s].
    - `acceleration`: Largest acceleration and deceleration [rad/s^2 | m/s^2].
    - `smoothing_samples`: Number N of samples of the moving average that smooths the profile; the
      jerk is at most 2 acceleration/(N sample_period_s).
    """

    speed: PositiveNumber
    acceleration: PositiveNumber
    smoothing_samples: SmoothingSamples


class Feedforward(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Effort that the modelled axis needs to follow its reference; it is added to the drive.

    The reference of the loop is delayed by the number of samples after which the drive acts.

    - `inertia`: Inertia [kg m^2 | kg].
    - `viscous`: Viscous friction [N m s/rad | N s/m].
    - `coulomb`: Coulomb friction [N m | N].
    - `switch_on_speed`: Speed of the reference above which the Coulomb friction is added [rad/s |
      m/s].
    - `switch_off_speed`: Speed of the reference below which the Coulomb friction is removed [rad/s
      | m/s].
    - `filter_rad_s`: Bandwidth of the state-variable filter that differentiates the reference; 0 if
      a prefilter or a profile provides the reference's speed.
    """

    inertia: Annotated[float, msgspec.Meta(ge=0)]
    viscous: Annotated[float, msgspec.Meta(ge=0)]
    coulomb: Annotated[float, msgspec.Meta(ge=0)]
    switch_on_speed: PositiveNumber
    switch_off_speed: Annotated[float, msgspec.Meta(ge=0)]
    filter_rad_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0

    def __post_init__(self) -> None:
        if self.switch_off_speed >= self.switch_on_speed:
            raise ValueError(
                f"switch_off_speed: found {self.switch_off_speed:g}; allowed: below "
                f"switch_on_speed, {self.switch_on_speed:g}"
            )


class DelayCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Properties of the sampled loop at one vertex for one computational delay.

    - `delay_samples`: Computational delay in samples.
    - `spectral_radius`: Largest magnitude of the loop's poles; below 1 the loop is stable.
    - `modulus_margin`: Modulus margin of the loop.
    """

    delay_samples: int
    spectral_radius: float
    modulus_margin: float


class Vertex(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One vertex of the plant polytope: its parameters (SI), and properties of its closed loop.

    - `name`: Name of the vertex.
    - `norm`: Norm from the weighted inputs to the weighted outputs, in the time domain of the
      synthesis (continuous or discrete).
    - `sampled_norm`: Norm of the sampled loop from the weighted inputs to the weighted outputs.
    - `modulus_margin`: Modulus margin of the sampled loop.
    - `stable`: True if the sampled loop is stable.
    - `checks`: Properties of the loop for each checked computational delay.
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
    """Worst margins of the sampled loops at all vertices, with the delay in bench.yaml.

    If the key of a margin is absent, the margin is unlimited.

    - `small_gain`: Largest norm of the transfer from the friction (divided by the Coulomb friction)
      to the speed [rad/s | m/s].
    - `gain_increase`, `gain_decrease`: Largest and smallest admissible factor on the loop gain.
    - `phase_deg`: Admissible additional phase lag.
    - `delay_s`: Admissible additional delay.
    """

    # small_gain is annex (27)
    small_gain: float
    gain_increase: float | None = None
    gain_decrease: float | None = None
    phase_deg: float | None = None
    delay_s: float | None = None


class Robustness(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Largest norm of the sampled loop for plants inside the intervals of the parameters.

    For a loop without weights, the peak of the sensitivity function replaces the norm. The block is
    absent if a certificate proves a bound. A missing key means that the value was not computed.
    `parameter_dependent` and `common` are valid for plants that are interpolated between the
    sampled models of the vertices.

    - `interior_points`: Number of plants at which the norm was computed.
    - `interior`: Largest norm at these plants and in a local search from the worst vertex. This is
      a lower bound of the true maximum.
    - `structured`: Upper bound for constant parameters, from D-G scalings; only files of older
      versions have this key.
    - `parameter_dependent`: Upper bound for constant parameters, from a Lyapunov matrix that
      depends on the parameters; only files of older versions have this key.
    - `common`: Upper bound from one Lyapunov matrix, for parameters that vary arbitrarily fast.
    """

    interior_points: int
    interior: float
    structured: float | None = None
    parameter_dependent: float | None = None
    common: float | None = None


class Rounded(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Properties of the closed loop with coefficients in a number format.

    - `number`: Number format to which the coefficients are rounded.
    - `gamma`: Largest norm of the sampled loop at all vertices.
    - `modulus_margin`: Smallest modulus margin at all vertices.
    """

    number: Number
    gamma: float
    modulus_margin: float


class Verified(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Verified properties of the loop; `frictool verify` computes them again.

    - `gamma_asked`: Bound of the norm that the synthesis method claims for the plants of the
      design; null if the method claims no bound.
    - `gamma_verified`: Largest norm of the sampled loop at all vertices, computed from the stored
      coefficients.
    - `modulus_margin_specified`: Modulus margin that the specification requires.
    - `vertices`: Properties of the loop at each vertex.
    - `count_drive`: Largest drive in response to one encoder count [A | V].
    - `rounded`: Properties of the loop with rounded coefficients.
    - `margins`: Worst margins of all vertices.
    - `robustness`: Largest norm for plants inside the intervals of the parameters.
    - `digests`: SHA-256 of each block at verification, by the block's name. Without digests
      `verify` ends with exit code 1.
    """

    # documents/digests.py
    gamma_asked: float | None
    gamma_verified: float
    modulus_margin_specified: float
    vertices: tuple[Vertex, ...]
    count_drive: float | None = None
    rounded: tuple[Rounded, ...] = ()
    margins: Margins | None = None
    robustness: Robustness | None = None
    digests: dict[str, str] = {}

    @property
    def modulus_margin(self) -> float:
        """Return the smallest modulus margin of all vertices."""
        return min(vertex.modulus_margin for vertex in self.vertices)


class Corner(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Controller at one corner of the intervals of the scheduled parameters.

    All corners have the same state coordinates. The parameters that are not scheduled are at the
    centres of their intervals.

    - `discrete`: Matrices of the controller at this corner.
    - `anti_windup`: Anti-windup gains at this corner. Between the corners, the target hardware
      interpolates the gains and the matrices.
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
    """Gain schedule: the controller depends on parameters that are known at run time.

    The controller's matrices are a weighted sum of the matrices at the corners of the parameter
    intervals. The weights follow from the present parameters.

    - `parameters`: Scheduled parameters.
    - `corners`: Controllers at the corners.
    - `gamma`: Largest norm of the sampled loop at the corners and at plants between them. Each
      plant is combined with the controller for its parameters.
    - `modulus_margin`: Smallest modulus margin of these plants.
    - `points`: Number of plants between the corners.
    """

    # weights (5.46), sum (5.64)
    parameters: tuple[Scheduled, ...]
    corners: tuple[Corner, ...]
    gamma: float
    modulus_margin: float
    points: int


class Controller(
    ObjectView, msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Coefficients for the target hardware, and verified properties of the loop: `controller.yaml`.

    - `structure`: `position` is a single loop of the position. `speed_cascade` is a speed loop
      whose reference comes from a position law.
    - `method`: Synthesis method, or `own` for a controller that was designed with another tool.
    - `domain`: Time domain of the synthesis.
    - `drive_limit`: Largest magnitude of the drive [A | V].
    - `sign_convention`: Text that explains the signs of error and drive.
    - `linear`: Linear controller.
    - `verified`: Properties of the loop that were verified.
    - `position_law`: Speed reference from the position error; present in structure `speed_cascade`.
    - `prefilter`: Low-pass filter of the reference.
    - `profile`: Profile from the present position to the reference.
    - `feedforward`: Effort that the modelled axis needs to follow its reference.
    - `velocity`: Source of the speed signal.
    - `limiter`: Block that switches the drive off near the target.
    - `friction_compensation`: Friction effort that is added to the drive.
    - `certificate`: Data that prove the bounds of the loop.
    - `weights`: Weights of the generalised plant in the verified norm; absent if the certificate
      contains them.
    - `schedule`: Controllers for gain scheduling, if the design requests them.
    - `resonances`: Resonances of the model. Stability and the modulus margin at the vertices
      include the resonances; norms and certificate do not.
    - `stiffness`: Stiffness of the spring in the model. Stability and the modulus margin at the
      vertices are verified without the spring and at both ends of the interval of the stiffness.
      Norms and certificate are valid without the spring.
    - `ringing`: Oscillation of the axis in the logs, which norms, margins and certificate do not
      include. `verify` tests the loop with plants that consist of two inertias and have this
      oscillation.
    - `logged_positions`: Positions of the logs of sliding motion from which the model was
      identified. Elsewhere, load and friction of the model are extrapolated.
    - `measurement_hold_samples`: Number of successive samples at which an invalid input is replaced
      by its last valid value. After more invalid samples, the drive becomes 0 and the fault flag is
      set.
    """

    # an external design: synth/external_design.py; invalid inputs: docs/theory/export.md
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
    profile: Profile | None = None
    feedforward: Feedforward | None = None
    velocity: Velocity = Velocity()
    limiter: Limiter | None = None
    friction_compensation: FrictionCompensation | None = None
    certificate: Certificate | None = None
    weights: CertifiedWeights | None = None
    schedule: Schedule | None = None
    resonances: Resonances | None = None
    stiffness: StiffnessEstimate | None = None
    ringing: Ringing | None = None
    logged_positions: PositionSpan | None = None
    measurement_hold_samples: HoldSamples = DEFAULT_HOLD_SAMPLES

    @property
    def judged_by(self) -> CertifiedWeights | None:
        """Return the weights of the verified norm; None if the loop's input is a speed.

        The weights come from the certificate or, without a certificate, from the key `weights`.
        """
        if self.linear.input == "speed_error":
            return None
        return self.certificate.weights if self.certificate is not None else self.weights

    def __post_init__(self) -> None:
        cascade = self.structure == "speed_cascade"
        if cascade != (self.position_law is not None):
            raise ValueError(
                "position_law: required with `structure: speed_cascade`, not allowed with "
                "`structure: position`"
            )
        if cascade and self.limiter is not None:
            raise ValueError(
                "`limiter` belongs to `structure: position`; in a cascade use position_law.action"
            )
        if self.profile is not None and self.prefilter is not None:
            raise ValueError("`profile` replaces `prefilter`; remove one of them")
        fed = self.feedforward
        filters = self.prefilter is not None or self.profile is not None
        if fed is not None and filters == (fed.filter_rad_s > 0.0):
            raise ValueError(
                "feedforward.filter_rad_s: allowed: 0 with a prefilter or profile, and above 0 "
                "without them"
            )
