"""A headless Chromium driven over its debugging pipe: pages are measured as a reader sees them, and
what they ask for is recorded."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome", "headless-shell")
WAIT = 60.0  # s for one answer; the first start on a busy machine is slow
QUIET = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-extensions",
    "--disable-background-networking",
)


def find() -> str | None:
    """The browser on the PATH."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


@dataclass
class Seen:
    """Events while a page was open: requested addresses, opened dialogs, errors and messages on its
    console."""

    requests: list[str] = field(default_factory=list)
    dialogs: list[str] = field(default_factory=list)
    console: list[str] = field(default_factory=list)


class Browser:
    """Commands of the DevTools protocol, one at a time, separated by zero bytes on the pipe."""

    def __init__(self, write: int, read: int) -> None:
        self.write, self.read, self.number, self.buffer = write, read, 0, b""
        self.session: str | None = None
        self.seen = Seen()
        os.set_blocking(read, False)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The result of one command; events that arrive meanwhile are recorded."""
        number, until = self._send(method, **parameters), time.monotonic() + WAIT
        while time.monotonic() < until:
            answers = [message for message in self._arrived() if message.get("id") == number]
            if answers:
                assert "error" not in answers[0], f"{method}: {answers[0]['error']}"
                return dict(answers[0]["result"])
        raise TimeoutError(f"{method}: no answer within {WAIT:g} s")

    def _send(self, method: str, **parameters: Any) -> int:
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        os.write(
            self.write,
            json.dumps(message | ({"sessionId": self.session} if self.session else {})).encode()
            + b"\0",
        )
        return self.number

    def _arrived(self) -> list[dict[str, Any]]:
        """The whole messages that have come; each one is recorded."""
        try:
            chunk = os.read(self.read, 1 << 20)
            assert chunk, "the browser has ended"
            self.buffer += chunk
        except BlockingIOError:
            time.sleep(0.005)
        *whole, self.buffer = self.buffer.split(b"\0")
        messages = [json.loads(text) for text in whole]
        for message in messages:
            self._record(message.get("method", ""), message.get("params", {}))
        return messages

    def _record(self, method: str, told: dict[str, Any]) -> None:
        if method == "Network.requestWillBeSent":
            self.seen.requests.append(told["request"]["url"])
        elif method == "Page.javascriptDialogOpening":
            self.seen.dialogs.append(told["message"])
            self._send("Page.handleJavaScriptDialog", accept=True)  # else the page waits for ever
        elif method == "Runtime.consoleAPICalled":
            self.seen.console.append(told["type"])
        elif method == "Log.entryAdded":
            self.seen.console.append(told["entry"]["text"])

    def open(self, page: Path, width: int, height: int = 900) -> Seen:
        """Loads a page in a window of this width; on a phone's with its pixel ratio."""
        self.session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        for domain in ("Page", "Network", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        phone = width < 720
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=2 if phone else 1,
            mobile=phone,
        )
        self.seen = Seen()
        self.call("Page.navigate", url=page.as_uri())
        until = time.monotonic() + WAIT
        while self.evaluate("document.readyState") != "complete":
            assert time.monotonic() < until, "the page does not load"
            time.sleep(0.02)
        time.sleep(0.1)  # for what a page may still ask for once it is there
        self.evaluate("1")
        return self.seen

    def evaluate(self, expression: str) -> Any:
        """The value of an expression in the page, through JSON."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")


@contextmanager
def browser(folder: Path) -> Iterator[Browser]:
    """A browser with its profile in `folder`."""
    path = find()
    assert path is not None
    theirs_in, ours_out = os.pipe()
    ours_in, theirs_out = os.pipe()

    def pipes() -> None:
        high_in, high_out = os.dup(theirs_in), os.dup(theirs_out)
        os.dup2(high_in, 3)
        os.dup2(high_out, 4)

    words = [path, *QUIET, "--remote-debugging-pipe", f"--user-data-dir={folder}", "about:blank"]
    process = subprocess.Popen(
        words,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        preexec_fn=pipes,
        close_fds=False,
    )
    os.close(theirs_in)
    os.close(theirs_out)
    try:
        yield Browser(ours_out, ours_in)
    finally:
        process.terminate()
        process.wait(timeout=WAIT)
        os.close(ours_out)
        os.close(ours_in)
