"""`make fuzz`: mutated inputs of every format at full count.

python -m tests.fuzz [COUNT [NAME...]]     COUNT inputs, 20000 of all formats where none is given;
                                           exit code 1 where one is found
python -m tests.fuzz NAME INDEX            one of them: written into the folder build/fuzz, with the
                                           command that reads it
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from tests.fuzz.child import command, input_of, place_for
from tests.fuzz.harness import SEED, fuzz
from tests.support import sample_files

COUNT = 20_000


def show(name: str, index: int) -> None:
    """Writes one input and the bench that reads it."""
    folder = Path("build", "fuzz")
    bench = folder / "bench.yaml"
    with tempfile.TemporaryDirectory() as made:
        sample = sample_files.write(name, Path(made))
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        sample_files.write_other(name, sample, bench)
        path = place_for(sample, folder)
        path.write_bytes(input_of(name, sample.read_bytes(), SEED, index))
    print(
        "frictool --debug",
        *command(name, index, sample_files.given(path), bench, folder / "out.mcap"),
    )


def main(arguments: list[str]) -> int:
    if arguments[:1] and arguments[0] in sample_files.names():
        show(arguments[0], int(arguments[1]))
        return 0
    result = fuzz(
        int(arguments[0]) if arguments else COUNT,
        names=arguments[1:],
        tell=lambda text: print(text, flush=True),
    )
    print(
        f"{result['inputs']} inputs of {result['formats']} formats in {result['seconds']:.0f} s: "
        f"{len(result['findings'])} findings"
    )
    return 0 if result["passed"] else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
