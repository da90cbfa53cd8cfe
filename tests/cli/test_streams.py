"""Standard streams that are full, closed, or no longer read: one line at the most, never a
traceback."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

COMMAND = [sys.executable, "-m", "frictool.cli.main", "schema", "bench"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_stdout_is_one_line_and_exit_3() -> None:
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(COMMAND, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 3
    assert done.stderr.startswith("error: stdout: ")
    assert done.stderr.count("\n") == 1


@pytest.mark.skipif(sys.platform == "win32", reason="a shell with >&- is needed")
def test_a_closed_stdout_is_no_failure() -> None:
    line = " ".join(f"'{word}'" for word in COMMAND) + " >&-"
    done = subprocess.run(["sh", "-c", line], stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(sys.platform == "win32", reason="a shell with a pipe is needed")
def test_a_reader_that_leaves_gets_no_traceback() -> None:
    line = " ".join(f"'{word}'" for word in COMMAND) + " | head -c 1"
    done = subprocess.run(["sh", "-c", line], capture_output=True, text=True, check=False)
    assert done.stdout == "{"
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="a shell with a pipe is needed")
def test_a_reader_that_leaves_is_no_answer() -> None:
    """Exit code 1 would say that the answer is no; the reader has left before anything is
    written."""
    words = " ".join(f"'{word}'" for word in COMMAND)
    line = f"{{ sleep 0.5; {words}; echo $? >&2; }} | true"
    done = subprocess.run(["sh", "-c", line], capture_output=True, text=True, check=False)
    assert done.stderr == "3\n"
