"""A Dask scheduler and workers, each a process of its own on the loopback."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]
PATIENCE_S = 60.0


class Loopback:
    """A scheduler that gives a task up after `failures` dead workers, and workers in a folder of
    their own; `settings`: for TLS."""

    def __init__(
        self, folder: Path, workers: int, failures: int = 3, settings: dict[str, str] | None = None
    ) -> None:
        self.folder = folder
        self._file = folder / "scheduler.json"
        quiet = {"DASK_DISTRIBUTED__LOGGING__DISTRIBUTED": "error"}
        self._environment = {**os.environ, **quiet, "PYTHONPATH": str(ROOT)}
        self._environment.pop("OPENBLAS_NUM_THREADS", None)  # as a machine has it
        self._environment["DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES"] = str(failures)
        self._environment |= {
            f"DASK_{key.upper().replace('.', '__').replace('-', '_')}": value
            for key, value in (settings or {}).items()
        }
        own = (
            "--port",
            "0",
            "--scheduler-file",
            str(self._file),
            "--protocol",
            "tls" if settings else "tcp",
        )
        self.scheduler = self._start("dask_scheduler", own)
        self.address = self._scheduler_address()
        self.workers = [self.add() for _ in range(workers)]

    def _scheduler_address(self) -> str:
        """Return the address from the scheduler's file, which is empty while it is written."""
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            try:
                return str(json.loads(self._file.read_text())["address"])
            except (FileNotFoundError, json.JSONDecodeError):
                time.sleep(0.02)
        raise TimeoutError(f"the scheduler wrote no address within {PATIENCE_S:g} s")

    def _start(self, module: str, arguments: Sequence[str]) -> subprocess.Popen[bytes]:
        line = [
            sys.executable,
            "-m",
            f"distributed.cli.{module}",
            "--host",
            "127.0.0.1",
            "--no-dashboard",
            *arguments,
        ]
        with (self.folder / f"{module}.log").open("ab") as log:
            return subprocess.Popen(
                line,
                cwd=self.folder,
                env=self._environment,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )

    def add(self, *options: str) -> subprocess.Popen[bytes]:
        """One more worker, which nothing starts again when it is ended."""
        own = ("--nthreads", "1", "--no-nanny", "--local-directory", str(self.folder))
        return self._start("dask_worker", (self.address, *own, *options))

    def close(self) -> None:
        """Ends what is left."""
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


def end(process: subprocess.Popen[bytes]) -> None:
    """As the system does where memory is short."""
    process.send_signal(signal.SIGKILL)
    process.wait()
