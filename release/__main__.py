"""`python -m release DIR`: builds the last commit twice, in surroundings that differ, compares, and
writes what is the same to DIR."""

from __future__ import annotations

import hashlib
import shutil
import sys
import tempfile
from pathlib import Path

from release.build import Failed, Surroundings, build
from release.contents import check
from release.source import epoch_of, source

ROOT = Path(__file__).parents[1]
TWICE = (
    Surroundings(umask=0o022, zone="UTC", language="C.UTF-8", hash_seed="0"),
    Surroundings(umask=0o077, zone="Asia/Kolkata", language="C", hash_seed="12345"),
)


def main(target: Path) -> None:
    """Raises Failed where two builds differ or something is missing; nothing is written then."""
    epoch = epoch_of(ROOT)
    with (
        tempfile.TemporaryDirectory() as first,
        tempfile.TemporaryDirectory(prefix="another-place-") as second,
    ):
        made = []
        for place, surroundings in zip((first, second), TWICE, strict=True):
            tree = source(ROOT, Path(place, "tree"))
            made.append(build(tree, Path(place, "out"), epoch, surroundings))
            check(tree, *made[-1])
        for one, other in zip(*made, strict=True):
            if one.read_bytes() != other.read_bytes():
                raise Failed(f"{one.name}: two builds of one commit differ")
        target.mkdir(parents=True, exist_ok=True)
        sums = ""
        for path in made[0]:
            shutil.copyfile(path, target / path.name)
            sums += f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n"
            print(f"{target / path.name}: {path.stat().st_size} bytes")
        (target / "SHA256SUMS").write_text(sums)
        print(f"two builds gave the same bytes\n{sums}", end="")


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "dist")
    except Failed as failed:
        sys.exit(f"error: {failed}")
