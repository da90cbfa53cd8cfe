"""Logs and documents of a synthetic clutch test in memory."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.controller import (
    Controller,
    DelayCheck,
    LinearController,
    PositionLaw,
    StateSpace,
    Verified,
    Vertex,
)
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.logs.log import Log, Stream
from frictool.typing import Vector
from studies.rigs.step_responses import second_order

ROOT = Path(__file__).parents[2]
PERIOD = 1e-3
ENCODER_STEP = 2 * math.pi / 56
REFERENCES = ((55.0, 1.1), (5.0, 1.1), (35.0, 1.1), (15.0, 20.0))
UNITS = {
    "position": "rad",
    "reference": "rad",
    "velocity": "rad/s",
    "current": "A",
    "command": "A",
    "load_position": "rad",
}
HOSTILE = (
    '<script>document.title="run";alert("x")</script><img src="http://127.0.0.1:9/x.png" '
    'onerror="alert(1)">'
)


def clutch_spec(**changes: object) -> Spec:
    """Return the specification of 5.4.1; `changes` replace its fields."""
    return msgspec.structs.replace(load(ROOT / "configs/clutch/spec.yaml", Spec), **changes)


def stream(
    topic: str = "/axis",
    *,
    damping: float = 0.8,
    frequency: float = 25.0,
    references: tuple[tuple[float, float], ...] = REFERENCES,
    start: float = 5.0,
    noise: float = 0.05,
    encoder_step: float = ENCODER_STEP,
    without: tuple[str, ...] = (),
) -> Stream:
    """Return second-order responses to a sequence of (reference, duration).

    The encoder rounds down; the drive is 0 after settling.
    """
    counts = [round(duration / PERIOD) for _, duration in references]
    time = np.arange(sum(counts), dtype=np.float64) * PERIOD
    reference = np.repeat([target for target, _ in references], counts)
    position, command, begin, origin = np.empty_like(time), np.zeros_like(time), 0, start
    for (target, _), count in zip(references, counts, strict=True):
        part = slice(begin, begin + count)
        local = np.arange(count, dtype=np.float64) * PERIOD
        position[part] = origin + (target - origin) * second_order(local, damping, frequency)
        command[part] = np.where(
            local < 0.5,
            np.clip((target - origin) * np.exp(-local / 0.05) * np.cos(local * 20), -50, 50),
            0.0,
        )
        begin, origin = begin + count, float(position[part][-1])
    noisy = command + noise * np.random.default_rng(7).standard_normal(time.size)
    measured = np.floor(position / encoder_step) * encoder_step if encoder_step else position
    signals = {
        "position": measured,
        "reference": reference,
        "velocity": np.gradient(position, PERIOD),
        "current": noisy,
        "command": command,
    }
    kept = {name: values for name, values in signals.items() if name not in without}
    return Stream(topic, time, kept, {name: UNITS[name] for name in kept})


def clutch_log(variants: int = 0, **options: Any) -> Log:
    """Return a log with the nominal stream and `variants` streams, each slower and less damped."""
    slower: list[dict[str, Any]] = [
        {"topic": f"/axis/v{k:02d}", "damping": 0.8 - 0.01 * k, "frequency": 25.0 - 0.3 * k}
        for k in range(variants)
    ]
    streams = [stream(**{**options, **change}) for change in [{}, *slower]]
    return Log(
        tuple(streams),
        {"provenance": {"command": "frictool simulate model.yaml", "frictool": "0.1.0"}},
        "run.mcap",
    )


def hostile_log() -> Log:
    """Return a log whose name, streams, channels and metadata contain a script and an image.

    A page must escape them.
    """
    named = Stream(
        f"/axis/{HOSTILE}",
        stream().time,
        {**stream(damping=0.5).signals, HOSTILE: stream().time},
        {**UNITS, HOSTILE: HOSTILE},
    )
    return Log((stream(), named), {HOSTILE: {HOSTILE: HOSTILE}}, f"{HOSTILE}.mcap")


def smooth_log() -> Log:
    """Return a measured log with a smooth reference, without holds and steps."""
    time = np.arange(4000, dtype=np.float64) * PERIOD
    reference: Vector = 10.0 * np.sin(2.0 * time)
    signals = {
        "position": np.round(reference / 0.1) * 0.1,
        "reference": reference,
        "current": 3.0 * np.cos(2.0 * time),
    }
    return Log(
        (Stream("/axis", time, signals, {name: UNITS[name] for name in signals}),), {}, "sines.mcap"
    )


def controller(
    margins: tuple[float, ...] = (0.73, 0.62, 0.68), unstable: int | None = None
) -> Controller:
    """Return a controller with these modulus margins at its vertices."""
    space = StateSpace(((0.5,),), ((1.0,),), ((0.1,),), ((0.2,),))
    vertices = tuple(
        Vertex(
            f"v{k:02d}",
            1.3e-5,
            3.8e-4,
            0.1,
            0.0134,
            1.0 / m,
            1.0 / m,
            m,
            k != unstable,
            (DelayCheck(1, 0.98, m),),
        )
        for k, m in enumerate(margins)
    )
    bench = load(ROOT / "configs/clutch/bench.yaml", Bench)
    return Controller(
        format="controller/1",
        name="speed",
        axis="rotary",
        structure="speed_cascade",
        method="lpv",
        domain="discrete",
        sample_period_s=PERIOD,
        delay_samples=1,
        drive="current",
        drive_limit=50.0,
        sign_convention="drive = H (integral of the speed reference - position)",
        linear=LinearController(space, space, ((0.1, 0.0, 0.0, 1.0, -0.5, 0.0),), (0.0,)),
        position_law=PositionLaw(
            gain=81.1, formula="sqrt(F/J)", band=2.0, action="cut", settled_speed=5.0
        ),
        verified=Verified(1.1, 1.05, 0.5, vertices),
        bench=bench,
        provenance=Provenance("frictool synth", "0.1.0"),
    )
