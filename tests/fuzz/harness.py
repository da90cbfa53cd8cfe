"""Hands mutated inputs to processes, starts another where one died, and gathers what was found."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from tests.fuzz.child import LONGEST
from tests.support import sample_files

SEED = 4
_FOUND = re.compile(r"found (\d+): (.*)")


def fuzz(
    count: int,
    seed: int = SEED,
    names: list[str] | None = None,
    tell: Callable[[str], None] = lambda text: None,
) -> dict[str, Any]:
    """`count` mutated inputs over the samples (all where none is named), as evenly as they divide.

    Returns {"passed", "inputs", "formats", "seconds", "findings": ["NAME SEED INDEX: what"]};
    python -m tests.fuzz NAME INDEX shows one.
    """
    chosen = names or sample_files.names()
    findings: list[str] = []
    start = time.perf_counter()
    shares = [
        (place + 1) * count // len(chosen) - place * count // len(chosen)
        for place in range(len(chosen))
    ]
    with ThreadPoolExecutor(os.cpu_count()) as workers:  # each waits for a process
        results = workers.map(lambda name, share: _one_format(name, seed, share), chosen, shares)
        for name, share, found in zip(chosen, shares, results, strict=True):
            tell(
                f"{name}: {share} inputs, {len(found)} findings, "
                f"{time.perf_counter() - start:.0f} s"
            )
            for text in found:
                tell(f"  {text}")
            findings += found
    seconds = time.perf_counter() - start
    return {
        "passed": not findings,
        "inputs": count,
        "formats": len(chosen),
        "seconds": seconds,
        "findings": findings,
    }


def _child(name: str, seed: int, first: int, count: int) -> subprocess.CompletedProcess[str]:
    words = [
        sys.executable,
        "-W",
        "error",
        "-m",
        "tests.fuzz.child",
        name,
        str(seed),
        str(first),
        str(count),
    ]
    return subprocess.run(words, capture_output=True, text=True)


def _one_format(name: str, seed: int, count: int) -> list[str]:
    """Return the complaints about the inputs of one sample. An input that took too long is tried
    once more, because the machine may have been busy."""
    findings, first = [], 0
    while first < count:
        done = _child(name, seed, first, count - first)
        findings += [
            f"{name} {seed} {index}: {what}" for index, what in _FOUND.findall(done.stdout)
        ]
        if done.returncode == 0:
            break
        reached = [
            int(line.split()[1]) for line in done.stdout.splitlines() if line.startswith("at ")
        ]
        if not reached:
            return [
                *findings,
                f"{name} {seed}: the sample itself fails: {done.stderr.strip().splitlines()[-1:]}",
            ]
        first = reached[-1] + 1
        if "Timeout" in done.stderr:
            done = _child(name, seed, reached[-1], 1)
            if done.returncode == 0:
                findings += [
                    f"{name} {seed} {index}: {what}" for index, what in _FOUND.findall(done.stdout)
                ]
                continue
        what = (
            f"ran for over {LONGEST:g} s"
            if "Timeout" in done.stderr
            else f"ended the process with {done.returncode}"
        )
        findings.append(
            f"{name} {seed} {reached[-1]}: {what}; "
            f"{' | '.join(done.stderr.strip().splitlines()[:12])}"
        )
    return findings
