"""Section 5.4.3.1 and annex C.5.2: gammas and transfer functions of the thesis's designs.

The figures are 5.12 to 5.17 and C.8 to C.10. The controllers are in continuous time, as designed in
the thesis; frictool designs those of the target differently (docs/theory/clutch.md).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.adapters.model_polytope import polytope, uncertain_polytope
from frictool.errors import NoSolutionError
from frictool.lmi.hinf_synthesis import (
    LyapunovPair,
    PoleDisc,
    controller,
    minimise,
    vertex_controllers,
)
from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti, tustin
from frictool.plant.polytope import PlantPoint, Polytope
from frictool.synth.slow_pole import with_integrator
from frictool.typing import Vector
from frictool.verify.speed_loop import check_loop
from studies.rigs.annex_model import COULOMB, annex_model
from studies.rigs.clutch_model import clutch_model
from studies.rigs.published_plants import LAG, READINGS, W2, annex_lft, annex_mixed, position
from studies.thesis.drawing import Curve, Row, draw
from studies.thesis.results import ComputedValue, Part

RECENTRING, DEFAULT_RECENTRING = 1.05, 1.1
RECENTRINGS = (1.01, 1.02, 1.05, 1.1, 1.3)
BANDWIDTH, MARGIN, STATIC = 20.0, 0.5, 2.0 / 63.0  # z2 [rad/s], M_mod, e_stat of 5.4.3.1
STRICT, RELAXED = (1.0, 63.0 / 50.0), (0.1, 0.05)  # W1, W3: first by (5.58), then relaxed
POLES = 300.0  # rad/s, bound of the poles: a thousand times the slow pole
PERIOD = 1e-3
NEAR = (50.0, 5000.0)  # rad/s, about the annex's bandwidth
UNIT = PlantWeights(FirstOrderWeight(1.0), 1.0, 1.0)
READING = "W4 = G4, W5 = 1, d = half-width of F_c"  # the choice without tuned values
FREQUENCIES = np.geomspace(1e-2, 1e4, 400)


def synthesis() -> Part:
    """Return the part with gammas and transfer functions."""
    part = Part()
    _position(part)
    _annex(part)
    return part


def _decibels(gains: NDArray[np.complex128] | Vector) -> Vector:
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(gains), 1e-9)))


def _annex_friction() -> Polytope:
    """Return table 5.2 with the annex's F_c, which reproduces both published gammas."""
    box = polytope(clutch_model())
    middle = box.centre.coulomb

    def moved(point: PlantPoint) -> PlantPoint:
        end = (
            COULOMB[1]
            if point.coulomb == middle
            else COULOMB[0]
            if point.coulomb < middle
            else COULOMB[2]
        )
        return PlantPoint(point.name, point.inertia, point.viscous, end, point.constant)

    return Polytope(moved(box.centre), tuple(moved(vertex) for vertex in box.vertices))


def _position(part: Part) -> None:
    """Add 5.4.3.1: the problem of the text, and the choice of F_c that reproduces its gamma.

    The figures show the frozen controller of this choice.
    """
    strict, relaxed = (
        minimise(position(BANDWIDTH, *weights), RECENTRING).optimum for weights in (STRICT, RELAXED)
    )
    part.add("section_5_4_3_1", {"gamma_strict": strict, "gamma_relaxed": relaxed})
    box = _annex_friction()
    met = minimise(position(BANDWIDTH, *STRICT, box=box), RECENTRING).optimum
    weights = PlantWeights(template(BANDWIDTH, MARGIN, STATIC), *RELAXED)
    centre = generalised_plant("position", box.centre.rates, LAG, weights)
    lyapunov = _lyapunov(box, centre, RECENTRING)
    part.add(
        "section_5_4_3_1", {"gamma_strict_annex": met, "gamma_relaxed_annex": lyapunov.optimum}
    )
    frozen, slow = (
        controller(centre, lyapunov),
        [_slowest(controller(centre, _lyapunov(box, centre, one))) for one in RECENTRINGS],
    )
    own = polytope(clutch_model())
    closed = [
        generalised_plant("position", point.rates, LAG, UNIT).closed(frozen)
        for point in (*own.vertices, own.centre)
    ]
    responses, middle = np.split(
        np.stack([loop.response(FREQUENCIES) for loop in closed]), [len(own.vertices)]
    )
    margins = 1.0 / np.max(np.abs(responses[:, :, 0, 0]), axis=1)
    peaks = np.max(np.abs(1.0 - responses[:, :, 0, 0]), axis=1)
    part.add(
        "section_5_4_3_1",
        {
            "order": str(frozen.order),
            "slow_pole": ComputedValue(
                _slowest(frozen),
                min(slow),
                max(slow),
                f"recentred at {RECENTRINGS[0]:g} to {RECENTRINGS[-1]:g} times gamma*",
            ),
            "stable": "all" if all(loop.stable for loop in closed) else "not all",
            "margin": float(margins.min()),
            "peak": ComputedValue(
                _beyond_one(middle),
                100.0 * (float(peaks.min()) - 1.0),
                100.0 * (float(peaks.max()) - 1.0),
                "over the vertices",
            ),
        },
    )
    floor = STRICT[1] * max(point.coulomb / point.constant for point in own.vertices)
    free = controller(
        centre, minimise([centre, *position(BANDWIDTH, *RELAXED, box=box)], RECENTRING)
    )
    part.say(
        "section_5_4_3_1",
        f"The rejection of table 5.2's largest friction costs {floor:.1f}: W3 by (5.58) times the "
        "current that cancels this friction.",
    )
    part.say(
        "section_5_4_3_1",
        f"Without bounds on its poles the relaxed controller's fastest is at {_fastest(free):.0f} "
        "rad/s.",
    )
    guaranteed = MARGIN / lyapunov.optimum
    part.say(
        "section_5_4_3_1",
        f"gamma = {lyapunov.optimum:.2f} guarantees M_mod/gamma = {guaranteed:.2f} for a "
        "scheduled controller.",
    )
    part.say(
        "section_5_4_3_1",
        f"Modulus margin of the frozen controller over the 16 vertices: {margins.min():.2f} to "
        f"{margins.max():.2f}.",
    )
    _draw_position(part, responses, frozen, lyapunov.optimum, weights)


def _lyapunov(box: Polytope, centre: GeneralisedPlant, recentring: float) -> LyapunovPair:
    """Return the Lyapunov pair of the relaxed problem with closed-loop poles within POLES."""
    return minimise(
        [centre, *position(BANDWIDTH, *RELAXED, box=box)], recentring, PoleDisc(-POLES, POLES)
    )


def _slowest(k: Lti) -> float:
    """Return the magnitude of the slowest pole [rad/s]."""
    return float(np.min(np.abs(np.linalg.eigvals(k.a))))


def _fastest(k: Lti) -> float:
    """Return the magnitude of the fastest pole [rad/s]."""
    return float(np.max(np.abs(np.linalg.eigvals(k.a))))


def _beyond_one(responses: NDArray[np.complex128]) -> float:
    """Return the largest excess of theta over theta_c over the frequencies [%]."""
    return float(100.0 * (np.max(np.abs(1.0 - responses[:, :, 0, 0])) - 1.0))


def _draw_position(
    part: Part, responses: NDArray[np.complex128], frozen: Lti, gamma: float, weights: PlantWeights
) -> None:
    """Draw figures 5.12 to 5.17."""
    w2 = weights.error.system(0.0).response(FREQUENCIES)[:, 0, 0]
    templates = {
        "5.13": gamma / w2,
        "5.14": np.full(w2.shape, gamma / weights.drive),
        "5.15": gamma / (weights.disturbance * w2),
    }
    entries = {
        "5.13": ("e/theta_c, dB", responses[:, :, 0, 0]),
        "5.14": ("i/theta_c, dB of A/rad", responses[:, :, 1, 0]),
        "5.15": ("e/w, dB of rad per unit of friction", responses[:, :, 0, 1]),
        "5.16": ("theta/theta_c, dB", 1.0 - responses[:, :, 0, 0]),
    }
    part.draw(
        "5.12",
        f"1/|W2|: low frequencies {1 / abs(w2[0]):.4f}, high {1 / abs(w2[-1]):.3g}, which is "
        "1/M_mod.",
        draw(
            "template", "rad/s", [("1/W2, dB", [Curve(FREQUENCIES, _decibels(1.0 / w2))])], log=True
        ),
    )
    for number, (label, gains) in entries.items():
        curves = [Curve(FREQUENCIES, _decibels(one)) for one in gains]
        caption = (
            "The 16 vertices of table 5.2, the controller frozen at the centre; largest "
            f"{_decibels(gains).max():.1f} dB."
        )
        if number in templates:
            curves.append(Curve(FREQUENCIES, _decibels(templates[number]), "template", "reference"))
            beyond = float(np.max(np.abs(gains) / np.abs(templates[number])))
            caption += f" Largest over its template (gamma {gamma:.2f}): {beyond:.2f} of it."
        part.draw(number, caption, draw(f"transfer {number}", "rad/s", [(label, curves)], log=True))
    sampled = with_integrator(tustin(frozen, PERIOD), BANDWIDTH)
    below = FREQUENCIES[: int(np.searchsorted(FREQUENCIES, 0.98 * np.pi / PERIOD))]
    both = [frozen.response(FREQUENCIES)[:, 0, 0], sampled.response(below)[:, 0, 0]]
    at = [float(abs(one.response(np.array([BANDWIDTH]))[0, 0, 0])) for one in (frozen, sampled)]
    rows: list[Row] = [
        (
            "gain, dB",
            [
                Curve(below, _decibels(both[1]), "sampled at 1 ms, with an integrator"),
                Curve(FREQUENCIES, _decibels(both[0]), "continuous"),
            ],
        ),
        (
            "phase, rad",
            [
                Curve(below, np.unwrap(np.angle(both[1]))),
                Curve(FREQUENCIES, np.unwrap(np.angle(both[0]))),
            ],
        ),
    ]
    part.draw(
        "5.17",
        f"At {BANDWIDTH:g} rad/s the two gains are {at[0]:.4f} and {at[1]:.4f} A/rad; at low "
        "frequencies they differ, because the sampled controller integrates.",
        draw("controller of 5.4.3", "rad/s", rows, log=True),
    )


def _annex(part: Part) -> None:
    """Add C.5.2: gamma of both forms, difference of the two LPV controllers, effect of sampling."""
    reading = READINGS[READING]
    lft = minimise([annex_lft(reading)], RECENTRING)
    plants = annex_mixed(reading)
    mixed = minimise(plants, DEFAULT_RECENTRING)
    slow, fast = vertex_controllers(plants, mixed)
    single = controller(annex_lft(reading), minimise([annex_lft(reading)], DEFAULT_RECENTRING))
    part.add("annex_c_5_2", {"gamma_lft": lft.optimum, "gamma_lpv_lft": mixed.optimum})
    for name, other in READINGS.items():
        if name != READING:
            found = (
                minimise([annex_lft(other)], RECENTRING).optimum,
                minimise(annex_mixed(other), RECENTRING).optimum,
            )
            part.say("annex_c_5_2", f'Read as "{name}": {found[0]:.3f} and {found[1]:.3f}.')
    below = 2.0 * np.pi * np.geomspace(1e-2, 1e3, 2000)
    apart = float(np.max(np.abs(fast.response(below) / slow.response(below) - 1.0)))
    radius = _sampled((slow, fast), reading.unit)
    part.add(
        "annex_c_5_2", {"apart": 100.0 * apart, "sampled": "stable" if radius < 1.0 else "unstable"}
    )
    part.say(
        "annex_c_5_2",
        f"Sampled by Tustin at 1 ms the larger spectral radius of the two loops is {radius:.2f}.",
    )
    _draw_annex(part, {"LFT": single, "LPV+LFT, rho = 0": slow, "LPV+LFT, rho = 1": fast}, apart)


def _sampled(controllers: tuple[Lti, ...], unit: float) -> float:
    """Return the larger spectral radius of both vertices' loops, sampled by Tustin at 1 ms."""
    _, plants = uncertain_polytope(annex_model(), ("regime",), unit)
    return max(
        check_loop(tustin(k, PERIOD), plant.rates, LAG, 0).spectral_radius
        for plant, k in zip(plants, controllers, strict=True)
    )


def _draw_annex(part: Part, controllers: dict[str, Lti], apart: float) -> None:
    """Draw figures C.8 to C.10: loops on the nominal axis, each with its own rho."""
    box = polytope(annex_model(), ("regime",))
    slow, fast = (
        vertex.rates
        for vertex in (box.vertices if box.vertices[0].viscous == 0.0 else box.vertices[::-1])
    )
    middle = box.centre.rates
    loops = {
        name: _loop(k, rates)
        for (name, k), rates in zip(controllers.items(), (middle, slow, fast), strict=True)
    }
    w2 = W2.system(0.0).response(FREQUENCIES)[:, 0, 0]
    curves = [Curve(FREQUENCIES, _decibels(loop[:, 0, 0]), name) for name, loop in loops.items()]
    drives = [Curve(FREQUENCIES, _decibels(loop[:, 1, 0])) for loop in loops.values()]
    rows: list[Row] = [
        ("e/omega_c, dB", [*curves, Curve(FREQUENCIES, _decibels(1.0 / w2), "1/W2", "reference")]),
        ("i/omega_c, dB", drives),
    ]
    peak = max(float(curve.y.max()) for curve in curves)
    near = slice(*np.searchsorted(FREQUENCIES, NEAR).tolist())
    apart_there = float(np.max(np.ptp([curve.y[near] for curve in curves], axis=0)))
    caption = (
        f"Largest sensitivity {peak:.1f} dB. Between {NEAR[0]:g} and {NEAR[1]:g} rad/s, the "
        f"curves are at most {apart_there:.1f} dB apart. At much lower frequencies, errors are "
        "smaller without viscous friction."
    )
    part.draw("C.8", caption, draw("annex sensitivities", "rad/s", rows, log=True))
    friction = [Curve(FREQUENCIES, _decibels(loop[:, 0, 1]), name) for name, loop in loops.items()]
    offset = float(np.max(np.abs(friction[1].y - friction[2].y)))
    part.draw(
        "C.9",
        f"From friction in units of its own F_c: rho = 0 and rho = 1 are up to {offset:.1f} dB "
        "apart, since F_c differs.",
        draw("annex friction", "rad/s", [("e/w, dB", friction)], log=True),
    )
    gains = [
        Curve(FREQUENCIES, _decibels(k.response(FREQUENCIES)[:, 0, 0]), name)
        for name, k in controllers.items()
    ]
    part.draw(
        "C.10",
        f"rho = 0 and rho = 1 differ by at most {100 * apart:.1f} % below 1 kHz.",
        draw("annex controllers", "rad/s", [("C, dB", gains)], log=True),
    )


def _loop(k: Lti, rates: AxisRates) -> NDArray[np.complex128]:
    found = generalised_plant("speed", rates, LAG, UNIT).closed(k)
    if not found.stable:
        raise NoSolutionError("a loop of annex C is not stable in continuous time")
    return found.response(FREQUENCIES)
