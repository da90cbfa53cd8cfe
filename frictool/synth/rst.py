"""Method `rst`: pole placement of an RST controller, as in the comparison of thesis 5.4.3.3.

The method works with structure `position` only. The tuning rule searches w, m and f and derives all
poles:

- dominant pair: natural frequency w and damping m; w >= 3/(response time), so that a disturbance
  also decays within the response time
- auxiliary poles: all others, real, at f w; a larger f rejects disturbances faster and amplifies
  noise
- delay: one pole at z = 0 for each sample of delay, as in the plant

The best w, m, f are chosen by these criteria, in order of priority: the nominal step response with
the prefilter is within 5 % in the specified time; the modulus margin at the worst vertex is at
least the specified margin; the nominal overshoot is at most the specified overshoot; the margin is
as large as possible. The margin is not guaranteed: the poles are placed at the centre of the
intervals, and the loop is then verified at every vertex.

The polynomial T of the reference equals S. The target hardware runs drive = (S/R)(reference -
position) behind the prefilter of the reference (thesis 5.69), with the same code as for every other
method.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from frictool.errors import NoSolutionError
from frictool.plant.linear_axis import linear_axis
from frictool.plant.lti import Lti, gain
from frictool.synth.pole_placement import PlacementVariable, place_poles, polynomial
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem
from frictool.synth.worst_norm import OpenLoopResponses, all_stable, sensitivity_plant, true_norms
from frictool.typing import Vector
from frictool.verify.hinf_norm import spectral_radius
from frictool.verify.margins import open_loop

ORDER = 5
DAMPINGS = (0.6, 0.7, 0.8, 0.9, 1.0)
FREQUENCIES = 10  # number of values tried first for w, and for f
STARTS = 2  # starts of the refinement, from the better quarter of the first tuning values
CLEAR = 1.01  # factor on the specified margin, because the margin is computed on a grid
REFINEMENTS = 6  # halvings of the search pattern around the best point
SETTLED = 0.05  # error at which the response has settled, as a fraction of the step (thesis 5.4.1)


@dataclass(frozen=True)
class PlacementRule:
    """Closed-loop poles to place: a dominant pair, and auxiliary poles at a higher frequency.

    `frequency` [rad/s], `damping`: natural frequency and damping ratio of the dominant pair.
    `ratio` is the frequency of the auxiliary poles divided by `frequency`.
    """

    frequency: float
    damping: float
    ratio: float


@dataclass(frozen=True)
class PlacementTrial:
    """Controller of a pole placement, with its nominal response time [s] and overshoot [%].

    `margin` is the smallest modulus margin of all vertices.
    """

    rule: PlacementRule
    controller: Lti
    response_time: float
    overshoot: float
    margin: float


def rst(problem: SynthesisProblem) -> ControllerCandidate:
    """Return the RST controller of the best tuning, even if it violates the specification.

    The tuning consists of the natural frequency w, the damping m and the frequency ratio f.
    Raises NoSolutionError if the controller's order is below the plant's order, or if no tuning is
    stable at every vertex.
    """
    tuning = _PlacementSearch(problem)
    best = tuning.best()
    rule = best.rule
    note = (
        f"rst: dominant poles at {rule.frequency:.3g} rad/s with damping {rule.damping:.2g}, "
        f"other poles at {rule.frequency * rule.ratio:.3g} rad/s; nominal linear response "
        f"{1e3 * best.response_time:.0f} ms, overshoot "
        f"{best.overshoot:.1f} %; modulus margin {best.margin:.3f} at the worst vertex; T = S "
        "with the prefilter"
    )
    return ControllerCandidate(
        problem.discretised(best.controller),
        best.controller,
        None,
        None,
        (note, *tuning.missed(best)),
    )


class _PlacementSearch:
    def __init__(self, problem: SynthesisProblem) -> None:
        self.problem = problem
        self.period = problem.period if problem.sampled else 0.0
        self.delay = problem.delay if problem.sampled else 0
        self.order = problem.design.order or ORDER
        centre = problem.box.centre
        if problem.sampled:
            nominal = open_loop(gain(1.0, self.period), centre.rates, problem.lag, self.delay)
        else:
            axis = linear_axis(centre.rates, problem.lag, 0.0).system
            nominal = Lti(axis.a, axis.b[:, :1], -axis.c[2:], np.zeros((1, 1)), 0.0)
        # rad/s: exp(-3) = 5 % after the response time
        self.slowest = 3.0 / (problem.spec.response_time_95_s or 0.2)
        self.scale = PlacementVariable(4.0 * self.slowest, self.period)
        self.a, self.b = self.scale.polynomials(nominal)
        self.free = len(self.a) - 1 + self.order - 2 - self.delay  # number of auxiliary poles
        if self.order < len(self.a) - 1:
            raise NoSolutionError(
                f"method rst: order {self.order} is below the order {len(self.a) - 1} of the plant "
                f"(axis, drive, delay); raise order to at least {len(self.a) - 1}"
            )
        self.plants = [
            sensitivity_plant(problem.plant(point.rates)) for point in problem.box.vertices
        ]
        top = 0.999 * np.pi / self.period if self.period else 100.0 / problem.period
        self.grid = np.geomspace(0.1 * self.slowest, top, 150)
        self.loops = OpenLoopResponses.joined(
            [OpenLoopResponses.of(plant, self.grid) for plant in self.plants]
        ).p22
        self.prefilter = problem.design.prefilter

    def best(self) -> PlacementTrial:
        """Return the best trial of a coarse grid, improved by local searches.

        Raises NoSolutionError if no trial is stable at every vertex.
        """
        trials: list[PlacementTrial] = []
        for frequency in self.slowest * np.geomspace(1.0, 20.0, FREQUENCIES):
            for damping in DAMPINGS:
                trials += [
                    trial
                    for ratio in np.geomspace(1.0, 30.0, FREQUENCIES)
                    if (trial := self.trial(PlacementRule(frequency, damping, ratio)))
                ]
        if not trials:
            raise NoSolutionError(
                "method rst: no choice of dominant and auxiliary poles is stable at every vertex "
                "with a stable controller; narrow the "
                "model's intervals, or write `method: minimax`"
            )
        ranked = sorted(trials, key=self.merit, reverse=True)
        refined = []
        for start in ranked[:: max(1, len(ranked) // (4 * STARTS))][:STARTS]:
            here = start
            for halving in range(REFINEMENTS):
                here = self.improved(here, 0.5 ** (halving + 1))
            refined.append(here)
        here = max(refined, key=self.merit)
        worst = max(value for value, _ in true_norms(here.controller, self.plants))
        return PlacementTrial(
            here.rule, here.controller, here.response_time, here.overshoot, 1.0 / worst
        )

    def improved(self, here: PlacementTrial, step: float) -> PlacementTrial:
        """Return the local optimum, found by repeated moves to the best neighbouring rule.

        `step` is the relative distance between neighbouring rules.
        """
        factors = np.exp(step * np.array([-1.0, 0.0, 1.0]))
        while True:
            rule = here.rule
            near = [
                trial
                for f in factors
                for m in 1.0 + 0.4 * step * np.array([-1.0, 0.0, 1.0])
                for r in factors
                if (
                    trial := self.trial(
                        PlacementRule(
                            max(self.slowest, rule.frequency * f),
                            min(1.0, rule.damping * m),
                            max(1.0, rule.ratio * r),
                        )
                    )
                )
            ]
            better = max([here, *near], key=self.merit)
            if self.merit(better) <= self.merit(here):
                return here
            here = better

    def merit(self, trial: PlacementTrial) -> tuple[float, float, float, float]:
        """Return the criteria of a trial in order of priority; larger is better.

        The first three criteria are 0 if met, else minus the violation. The last criterion is the
        margin.
        """
        required = CLEAR * (self.problem.spec.modulus_margin or 0.0)
        return (
            -self.late(trial),
            min(0.0, trial.margin - required),
            -self.over(trial),
            trial.margin,
        )

    def late(self, trial: PlacementTrial) -> float:
        allowed = self.problem.spec.response_time_95_s
        return max(0.0, trial.response_time / allowed - 1.0) if allowed else 0.0

    def over(self, trial: PlacementTrial) -> float:
        allowed = self.problem.spec.overshoot_percent
        return max(0.0, trial.overshoot - allowed) if allowed is not None else 0.0

    def missed(self, trial: PlacementTrial) -> tuple[str, ...]:
        late, margin, over, _ = self.merit(trial)
        names = (
            ["response time"] * (late < 0.0)
            + ["modulus margin"] * (margin < 0.0)
            + ["overshoot"] * (over < 0.0)
        )
        return (
            (f"rst: no choice of poles meets the specified {', '.join(names)} in the linear loop",)
            if names
            else ()
        )

    def trial(self, rule: PlacementRule) -> PlacementTrial | None:
        """Return the trial of a rule; None if the controller or the loop at a vertex is unstable.

        An integrator of the controller does not count as unstable.
        """
        pair = rule.frequency * complex(-rule.damping, np.sqrt(1.0 - rule.damping**2))
        scale = self.scale
        poles = [
            scale.pole(pair),
            scale.pole(pair.conjugate()),
            *[scale.pole(-rule.frequency * rule.ratio)] * self.free,
        ]
        poles += [-1.0 / scale.step] * self.delay  # z = 0
        try:
            r, s = place_poles(self.a, self.b, polynomial(poles), self.order)
        except np.linalg.LinAlgError:
            return None
        k = scale.system(s, r)
        rest = k.a[1:, 1:]
        if not (
            spectral_radius(rest) < 1.0
            if self.period
            else bool(np.all(np.linalg.eigvals(rest).real < 0.0))
        ):
            return None
        if not all_stable(k, self.plants):
            return None
        response = np.tile(k.response(self.grid)[:, 0, 0], len(self.plants))
        margin = float(np.min(np.abs(1.0 - self.loops * response)))
        time, overshoot = self.step(k)
        return PlacementTrial(rule, k, time, overshoot, margin)

    def step(self, k: Lti) -> tuple[float, float]:
        """Return the response time to within 5 % [s] and the overshoot [%] of the nominal loop.

        The loop is linear, and its reference is a step through the prefilter.
        """
        problem = self.problem
        period = problem.period
        running = problem.discretised(k)
        loop = open_loop(running, problem.box.centre.rates, problem.lag, problem.delay)
        reference = np.ones(int(3.0 * (problem.spec.response_time_95_s or 0.2) / period) + 1)
        if self.prefilter is not None:
            w, m = self.prefilter.natural_frequency_rad_s, self.prefilter.damping
            reference = scipy.signal.lfilter(
                *scipy.signal.bilinear([1.0], [1.0 / w**2, 2.0 * m / w, 1.0], 1.0 / period),
                reference,
            )
        a = loop.a - loop.b @ loop.c
        if spectral_radius(a) >= 1.0:
            return np.inf, np.inf
        position = _simulated(a, loop.b, loop.c, reference)
        outside = np.flatnonzero(np.abs(position - 1.0) > SETTLED)
        return float((outside[-1] + 1) * period) if outside.size else 0.0, float(
            100.0 * max(0.0, np.max(position) - 1.0)
        )


def _simulated(a: Vector, b: Vector, c: Vector, entering: Vector) -> Vector:
    x, response = np.zeros(len(a)), np.empty(len(entering))
    for k, value in enumerate(entering):
        response[k] = c[0] @ x
        x = a @ x + b[:, 0] * value
    return response
