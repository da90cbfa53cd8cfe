"""Results of a study that are kept in a file, so that the study continues after an interruption."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar


class NumberedResult(Protocol):
    """Dataclass with the result for one number of a seed."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def number(self) -> int:
        """Return the number of the actuator."""


Result = TypeVar("Result", bound=NumberedResult)


def kept_results(
    seed: str,
    numbers: Sequence[int],
    kept: Path,
    run_one: Callable[[str, int], Result],
    kind: Callable[..., Result],
    cores: int = 1,
) -> Iterator[Result]:
    """Yield the results of a seed for `numbers` as they end.

    Each result is appended to the file `kept`. Results of this seed in the file are not computed
    again. `kind` makes a result from the fields of a line of the file.
    """
    header = json.dumps({"seed": seed})
    lines = kept.read_text().splitlines() if kept.is_file() else []
    results = (_read(line, kind) for line in lines[1:]) if lines[:1] == [header] else ()
    done = {result.number: result for result in results if result is not None}
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.write_text("".join(f"{line}\n" for line in (header, *map(_line, done.values()))))
    yield from (done[number] for number in numbers if number in done)
    for result in _run(seed, [one for one in numbers if one not in done], run_one, cores):
        with kept.open("a") as file:
            file.write(f"{_line(result)}\n")
        yield result


def _run(
    seed: str, numbers: Iterable[int], run_one: Callable[[str, int], Result], cores: int
) -> Iterator[Result]:
    if cores == 1:
        yield from (run_one(seed, number) for number in numbers)
        return
    with ProcessPoolExecutor(cores, get_context("spawn")) as pool:
        for job in as_completed([pool.submit(run_one, seed, number) for number in numbers]):
            yield job.result()


def _line(result: NumberedResult) -> str:
    return json.dumps(asdict(result))


def _read(line: str, kind: Callable[..., Result]) -> Result | None:
    """Return the result of a line; None for a line that was not written completely."""
    try:
        return kind(**json.loads(line))
    except (ValueError, TypeError):
        return None
