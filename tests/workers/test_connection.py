"""The way to a scheduler by TLS: work done with certificates, and one line at once where they are
not what they have to be."""

from __future__ import annotations

import shutil
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from frictool.errors import ClusterError
from frictool.workers import dask_connection
from frictool.workers.job_sharing import share
from tests.support.local_cluster import Loopback
from tests.support.worker_jobs import negative
from tests.workers.certificates import certificates

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")
pytestmark = pytest.mark.skipif(
    shutil.which("openssl") is None, reason="certificates are made by openssl"
)
TLS = "distributed.comm.tls"


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return certificates(tmp_path_factory.mktemp("certificates") / "bench")


@pytest.fixture(scope="module")
def strangers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return certificates(tmp_path_factory.mktemp("strangers") / "other")


@pytest.fixture(scope="module")
def loopback(
    settings: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Loopback]:
    made = Loopback(tmp_path_factory.mktemp("tls"), workers=1, settings=settings)
    yield made
    made.close()


def shared(address: str, settings: dict[str, Any]) -> dict[int, int]:
    with dask.config.set(settings):
        return dict(share(negative, range(5), cluster=address))


def refused(address: str, settings: dict[str, Any]) -> str:
    with pytest.raises(ClusterError) as error:
        shared(address, settings)
    assert str(error.value).startswith(f"{address}: ")
    return str(error.value).removeprefix(f"{address}: ")


def test_work_is_done_by_tls_and_by_nobody_without_its_certificates(
    loopback: Loopback, settings: dict[str, str], strangers: dict[str, str]
) -> None:
    assert loopback.address.startswith("tls://")
    assert shared(loopback.address, settings) == {number: -number for number in range(5)}
    plain = loopback.address.replace("tls", "tcp")
    assert f"try {loopback.address}, or another port" in refused(plain, {})
    assert "scheduler's certificate is not accepted" in refused(loopback.address, strangers)
    own = {f"{TLS}.client.{part}": strangers[f"{TLS}.client.{part}"] for part in ("cert", "key")}
    assert "client.cert in Dask's configuration, distributed.comm.tls has to be signed" in refused(
        loopback.address, {**settings, **own}
    )


def test_certificates_that_are_no_good_are_told_before_anything_is_asked(
    settings: dict[str, str], strangers: dict[str, str], tmp_path: Path
) -> None:
    nowhere = "tls://127.0.0.1:1"
    assert refused(nowhere, {}).startswith("TLS needs certificates; set ca-file and client.cert in")
    assert "no file missing.pem, which ca-file names" in refused(
        nowhere, {**settings, f"{TLS}.ca-file": "missing.pem"}
    )
    key = strangers[f"{TLS}.client.key"]
    assert "cannot be used: key values mismatch" in refused(
        nowhere, {**settings, f"{TLS}.client.key": key}
    )
    (tmp_path / "text.pem").write_text("no certificate")
    assert "PEM" in refused(nowhere, {**settings, f"{TLS}.client.cert": str(tmp_path / "text.pem")})
    assert "requires encryption" in refused(
        "tcp://127.0.0.1:1", {"distributed.comm.require-encryption": True}
    )
    assert "min-version=7 is not supported" in refused(
        nowhere, {**settings, f"{TLS}.min-version": 7}
    )


def test_who_answers_and_is_no_scheduler_is_told(
    settings: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    answers, greetings = (
        b"HTTP/1.1 400 Bad Request\r\n\r\n",
        3,
    )  # a plain one, one by TLS, and one that asks why that failed
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]

        def answer() -> None:
            for _ in range(greetings):
                with server.accept()[0] as other:
                    other.recv(65536)
                    other.sendall(answers)

        one = threading.Thread(target=answer, daemon=True)
        one.start()
        assert f"does not answer as a Dask scheduler; try tls://127.0.0.1:{port}" in refused(
            f"tcp://127.0.0.1:{port}", {}
        )
        assert f"does not use TLS; try tcp://127.0.0.1:{port}" in refused(
            f"tls://127.0.0.1:{port}", settings
        )
        one.join(5.0)
        monkeypatch.setattr(dask_connection, "CONNECT_S", 0.2)
        assert "no Dask scheduler answers" in refused(f"tcp://127.0.0.1:{port}", {})
