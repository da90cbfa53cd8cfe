"""Campaigns of the clutch: steps on plants drawn from the bench's ranges, judged by 5.4.1.

campaign.judged_trial       processor time of a trial, from the draw to the verdict; at most 0.8 ms
                            is required. The peer simulates and judges the same draws one after
                            another by the functions of `simulate` and `report`. The accuracy is the
                            largest relative difference of a value.
campaign.hundred_thousand   wall time of 100 000 trials on 2 cores, with their statistics. It must
                            be at most 60 times the wall time of 1000 trials in one thread.
campaign.pool_*             wall time of a judged trial of one step of 1.1 s. In two processes, the
                            peer moves the same plants under the same controller by scipy's
                            `solve_ivp` with events, without a judgement. The encoder's quantiser
                            amplifies rounding errors. The accuracy is therefore the number of
                            plants whose final positions differ by less than one encoder count.
"""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.timing import pair
from frictool.adapters.axis_model import axis_of
from frictool.adapters.controller_composition import controller_program
from frictool.campaign.draws.sampling import draws_of
from frictool.campaign.statistics.findings import find
from frictool.campaign.trials.trial_player import TrialPlayer, metrics_of, plant_of
from frictool.campaign.trials.trial_sharing import run_trials
from frictool.campaign.trials.trial_store import TrialStore
from frictool.campaign.trials.trials import Trials
from frictool.control.compiled_program import compile_program, control_step, start_at
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario, Step
from frictool.engine.closed_loop import measure
from frictool.plant.axis import rest
from frictool.report.verdict import judge
from frictool.simulate.closed_loop import StepTest
from frictool.workers.job_sharing import share
from studies.references.event_integration import event_integration
from studies.rigs.campaign_rig import trial

CLUTCH = Path(__file__).parents[1] / "configs" / "clutch"
MANY, FEW, CORES, ALLOWED = 100_000, 1000, 2, 60.0
JUDGED, STAGED = 2000, 200
TARGET, SECONDS, PLANTS, PEER_PLANTS, ROUNDS = 55.0, 1.1, 4000, 8, 3
USUAL: dict[str, Any] = {"method": "RK45", "rtol": 1e-6, "max_step": np.inf}
FINE: dict[str, Any] = {"method": "DOP853", "rtol": 1e-10, "max_step": np.inf}


def steps() -> TrialPlayer:
    """Return a player of trials: one step of 1.1 s on drawn clutches."""
    return trial(None, steps=(Step(Quantity(value=TARGET, unit="rad"), SECONDS),), drive_noise=0.0)


def campaign(play: TrialPlayer, count: int, cores: int) -> Trials:
    """Run `count` trials on `cores` cores."""
    units = draws_of("random", count, play.space.size, seed=1).units
    begun = time.perf_counter()
    metrics = metrics_of(play.nominal())
    shared = functools.partial(_shared, cores)
    return run_trials(
        play,
        metrics,
        units,
        TrialStore(None, {}),
        shared,
        each_s=time.perf_counter() - begun,
    )


def _shared(cores: int, function: Any, jobs: Any, batch: int, instead: Any) -> Any:
    return share(function, jobs, cores=cores, batch=batch, instead=instead)


def campaign_judged_trial() -> dict[str, Any]:
    """Return the row of a trial in a campaign, compared with separate stages."""
    life = load(CLUTCH / "scenarios" / "campaign.yaml", Scenario)
    play = trial(life.spread, life.seed, steps=life.steps, drive_noise=life.drive_noise)
    units = draws_of("random", JUDGED, play.space.size, life.seed).units
    setting = play.setting
    plant = plant_of(setting.plant)

    def staged(draw: int) -> list[float]:
        drawn = play.scenario(units[draw], draw)
        log = StepTest(plant, setting.controller).log(drawn)
        one = judge(setting.spec, [log], setting.controller)
        return [math.nan if each.value is None else each.value for each in one.requirements]

    def seconds(of: Callable[[int], Any], draws: Sequence[int]) -> tuple[float, list[Any]]:
        of(0)
        begun = time.process_time()
        results = [of(draw) for draw in draws]
        return (time.process_time() - begun) / len(draws), results

    ours, mine = seconds(lambda draw: play.played(units[draw], draw), range(JUDGED))
    theirs, others = seconds(staged, range(STAGED))
    margin = [metric.name for metric in metrics_of(play.nominal())].index("modulus_margin")
    apart = max(
        abs(value - other) / abs(other)
        for one, of_stages in zip(mine, others, strict=False)
        for index, (value, other) in enumerate(zip(one.metric_values, of_stages, strict=True))
        # `judge` also counts the controller's vertices; an infinite value has no number there
        if index != margin and math.isfinite(value) and other != 0.0
    )
    return {
        "id": "campaign.judged_trial",
        "peer": "simulate and judge, one draw after another",
        "ours": ours,
        "theirs": theirs,
        "unit": "s of processor time/trial",
        "ratio": theirs / ours,
        "accuracy": f"{JUDGED} trials; figures differ by {apart:.1g} at most on {STAGED}",
    }


def campaign_hundred_thousand() -> dict[str, Any]:
    """Return the row of 100 000 trials on two cores.

    The peer is 60 times the time of 1000 trials in one thread.
    """
    play = steps()
    campaign(play, 10, 1)
    seconds = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        campaign(play, FEW, 1)
        seconds.append(time.perf_counter() - begun)
    begun = time.perf_counter()
    found = find(campaign(play, MANY, CORES), "random")
    ours, theirs = time.perf_counter() - begun, sorted(seconds)[ROUNDS // 2]
    return {
        "id": "campaign.hundred_thousand",
        "peer": f"{ALLOWED:g} x {FEW} in one thread",
        "ours": ours,
        "theirs": ALLOWED * theirs,
        "unit": "s",
        "ratio": ALLOWED * theirs / ours,
        "accuracy": f"{MANY} on {CORES} cores in {ours / theirs:.3g} times {FEW} in one thread; "
        f"{found.rate.passed} pass",
    }


def campaign_pool_usual() -> dict[str, Any]:
    """Return the row against RK45 with a relative tolerance of 1e-6."""
    return _against_pool("campaign.pool_usual", USUAL)


def campaign_pool_fine() -> dict[str, Any]:
    """Return the row against DOP853 with a relative tolerance of 1e-10."""
    return _against_pool("campaign.pool_fine", FINE)


def _against_pool(name: str, options: dict[str, Any]) -> dict[str, Any]:
    play = steps()
    units = draws_of("random", PEER_PLANTS, play.space.size, seed=1).units
    values = [
        dict(zip(play.space.names, map(float, row), strict=True))
        for row in play.space.values(units)
    ]
    ends: NDArray[np.float64] = np.empty(0)
    with ProcessPoolExecutor(CORES, get_context("forkserver")) as pool:

        def theirs() -> None:
            nonlocal ends
            ends = np.array(list(pool.map(_moved, values, [options] * PEER_PLANTS)))

        ours_all, theirs_all = pair(lambda: campaign(play, PLANTS, CORES), theirs, ROUNDS)
    exact = [
        play.test.log(play.scenario(unit, draw), with_speed=False)
        .streams[0]
        .signals["position_true"][-1]
        for draw, unit in enumerate(units)
    ]
    count = play.test.plant.rig.resolution
    near = int(np.sum(np.abs(ends - np.array(exact)) < count))
    ours, peer = ours_all / PLANTS, theirs_all / PEER_PLANTS
    told = f"{options['method']} {options['rtol']:g}"
    return {
        "id": name,
        "peer": f"pool over solve_ivp {told}",
        "ours": ours,
        "theirs": peer,
        "unit": "s/trial",
        "ratio": peer / ours,
        "accuracy": f"{near} of {PEER_PLANTS} peers end within a count of ours; ours with the "
        "start of its processes, judged",
    }


def _moved(values: dict[str, float], options: dict[str, Any]) -> float:
    """Return the final position of a plant under the sampled controller.

    The controller runs in Python; `solve_ivp` moves the plant between the samples.
    """
    play = steps()
    controller, model = play.setting.controller, play.setting.plant
    axis, period = axis_of(model, **values), controller.sample_period_s
    running, state, waiting = (
        compile_program(controller_program(controller)),
        rest(5.0),
        [0.0] * controller.delay_samples,
    )
    start_at(running, measure(float(state[0]), axis.encoder_step))
    for _ in range(math.floor(SECONDS / period + 0.5)):
        waiting.append(
            control_step(
                running, TARGET, measure(float(state[0]), axis.encoder_step), float(state[1])
            )
        )
        state[:4] = event_integration(axis, state, waiting.pop(0), period, options)
    return float(state[0])


ROWS = [campaign_judged_trial, campaign_hundred_thousand, campaign_pool_usual, campaign_pool_fine]
