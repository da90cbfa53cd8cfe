"""Complete example rigs that `init --example` writes: documents, Makefile and logs."""

from __future__ import annotations

from pathlib import Path

EXAMPLES = {
    "clutch": "robotised clutch: coarse encoder, backlash, current drive (simulated logs)",
    "emps": "carriage on a ball screw: fine encoder, voltage drive (simulated logs)",
    "joint": "robot joint: 2000 counts per turn, columns with the rig's names (simulated logs)",
}
FOLDER = Path(__file__).parent / "examples"
TEMPLATES = Path(__file__).parent / "templates"
PACKED = ".xz"


def example_files(name: str) -> dict[str, str]:
    """Return the texts of the example rig `name` (a key of EXAMPLES), by path in the rig."""
    import lzma

    import jinja2

    folder = FOLDER / name
    files = {}
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        target = path.relative_to(folder).as_posix().removesuffix(PACKED)
        content = path.read_bytes()
        files[target] = (lzma.decompress(content) if path.suffix == PACKED else content).decode()
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES), keep_trailing_newline=True, autoescape=False
    )
    return {**files, "Makefile": environment.get_template("Makefile.jinja").render(log_path=None)}
