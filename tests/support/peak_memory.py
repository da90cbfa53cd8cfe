"""The most memory that a command needs, measured in a process of its own.

VmHWM is the process's own: ru_maxrss begins with that of the process that started it, which may be
larger.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

RUN = """
import sys
from frictool.cli.main import main
sys.argv[0] = "frictool"
try:
    main()
except SystemExit as stop:
    assert not stop.code, stop.code
peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(peak.split()[1], file=sys.stderr)
"""


def peak_mb(*arguments: str | Path) -> float:
    """MB of resident memory. Raises subprocess.CalledProcessError where the command fails."""
    done = subprocess.run(
        [sys.executable, "-c", RUN, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=True,
    )
    return int(done.stderr.splitlines()[-1]) / 1024.0
