"""Connection to a Dask scheduler, without or with TLS, with one-line messages about failures.

    address ──▶ Dask's configuration ──▶ first connection with Dask's greeting ──▶ client
                certificates are missing     refused, other certificates, no answer,
                or do not match the key      or no scheduler

The words below a step are its possible failures.

TLS: https://distributed.dask.org/en/latest/tls.html.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import logging
import re
import socket
import ssl
import warnings
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from frictool.errors import ClusterError

ADDRESS = re.compile(r"(tcp|tls)://(\[[0-9a-fA-F:.]+\]|[^\s:/\[\]]+):\d{1,5}")
CONNECT_S = 10.0  # s, longest wait for the scheduler's answer
CERTIFICATES = "Dask's configuration, distributed.comm.tls"
# OpenSSL's reasons for an unencrypted answer
NO_TLS = ("WRONG_VERSION_NUMBER", "HTTP_REQUEST", "RECORD_LAYER_FAILURE")
DEPTH = 10  # nested causes of an exception that are examined


@contextlib.contextmanager
def connect(address: str) -> Iterator[Any]:
    """Yield a client of the scheduler without Dask's log messages; may raise ClusterError."""
    if not ADDRESS.fullmatch(address):
        raise ClusterError(
            f"{address!r} is not the address of a Dask scheduler; "
            "allowed: tcp://HOST:PORT, tls://HOST:PORT"
        )
    dask, distributed = _libraries(address)
    for name in ("distributed.client", "distributed.core"):
        # this program reports a lost connection in one line
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 GiB"}):
        client = _client(dask, distributed, address)
        try:
            yield client
        finally:
            with contextlib.suppress(Exception):  # a lost scheduler cannot be notified
                client.close(timeout=1.0)


def _libraries(address: str) -> tuple[Any, Any]:
    try:
        return importlib.import_module("dask"), importlib.import_module("distributed")
    except ModuleNotFoundError:
        raise ClusterError(
            f"{address}: needs dask.distributed, which is not installed: "
            "pip install 'frictool[cluster]'"
        ) from None
    except ValueError as error:
        raise ClusterError(f"{address}: Dask's configuration cannot be read: {error}") from None


def _client(dask: Any, distributed: Any, address: str) -> Any:
    # with a security loader, only Dask has the certificates
    if not dask.config.get("distributed.client.security-loader", None):
        _greet(distributed, address, _certified(distributed, address))
    try:
        # Dask warns about versions, which `dask_cluster.py` compares itself
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return distributed.Client(
                address, timeout=CONNECT_S, set_as_default=False, name="frictool"
            )
    except (OSError, TimeoutError):
        raise ClusterError(_nobody(address)) from None
    except (ImportError, TypeError, ValueError) as error:
        raise ClusterError(f"{address}: the connection failed: {error}") from None


def _certified(distributed: Any, address: str) -> dict[str, Any]:
    try:
        security = distributed.Security()
    except ValueError as error:
        raise ClusterError(f"{address}: Dask's configuration: {error}") from None
    if address.startswith("tcp:"):
        if security.require_encryption:
            raise ClusterError(
                f"{address}: Dask's configuration requires encryption "
                "(distributed.comm.require-encryption); give tls://"
            )
        return {}
    paths = {
        "ca-file": security.tls_ca_file,
        "client.cert": security.tls_client_cert,
        "client.key": security.tls_client_key,
    }
    unset = [name for name in ("ca-file", "client.cert") if not paths[name]]
    if unset:
        raise ClusterError(
            f"{address}: TLS needs certificates; set {' and '.join(unset)} in {CERTIFICATES}"
        )
    for name, path in paths.items():
        if path and "\n" not in path and not Path(path).is_file():
            raise ClusterError(
                f"{address}: there is no file {path}, which {name} names in {CERTIFICATES}"
            )
    try:
        return dict(security.get_connection_args("client"))
    except ssl.SSLError as error:
        reason = error.reason or "check that each is in PEM form"
        raise ClusterError(
            f"{address}: the certificates in {CERTIFICATES} cannot be used: {_words(reason)}"
        ) from None
    except OSError as error:
        raise ClusterError(
            f"{address}: the certificates in {CERTIFICATES} cannot be read: {error.strerror}"
        ) from None


def _greet(distributed: Any, address: str, certificates: dict[str, Any]) -> None:
    async def greeting() -> None:
        comm = await asyncio.wait_for(
            distributed.comm.connect(address, timeout=CONNECT_S, **certificates), CONNECT_S + 1.0
        )
        await comm.close()

    try:
        _finish(greeting)
    except Exception as error:  # any exception, because anything may answer at the address
        raise ClusterError(_barred(address, error, certificates)) from None


def _finish(work: Callable[[], Coroutine[Any, Any, None]]) -> None:
    """Run `work`; use another thread if this thread already has an event loop (notebook)."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        asyncio.run(work())
        return
    with ThreadPoolExecutor(1) as executor:
        executor.submit(lambda: asyncio.run(work())).result()


def _barred(address: str, error: BaseException, certificates: dict[str, Any]) -> str:
    causes = list(_causes(error))
    if any(
        isinstance(cause, ConnectionRefusedError | TimeoutError) for cause in causes
    ) or "Timed out" in str(error):
        return _nobody(address)
    failed = _failure_of_tls(address, certificates["ssl_context"]) if certificates else None
    if isinstance(failed, ssl.SSLCertVerificationError):
        why = f"{failed.verify_message}; it has to be signed by ca-file in {CERTIFICATES}"
        return f"{address}: the scheduler's certificate is not accepted: {why}"
    if failed is not None and failed.reason not in NO_TLS:
        why = (
            f"{_words(failed.reason or str(failed))}; "
            f"client.cert in {CERTIFICATES} has to be signed by the scheduler's ca-file"
        )
        return f"{address}: TLS fails: {why}"
    scheme, _, location = address.partition("://")
    other = f"{'tcp' if scheme == 'tls' else 'tls'}://{location}"
    what = "does not use TLS" if failed is not None else "does not answer as a Dask scheduler"
    return (
        f"{address}: the server at this address {what}; try {other}, or another port "
        "(8787 is the dashboard)"
    )


def _failure_of_tls(address: str, context: ssl.SSLContext) -> ssl.SSLError | None:
    """Return the TLS error of a handshake with the scheduler; None if there is no TLS error."""
    host, _, port = address.partition("://")[2].rpartition(":")
    try:
        with (
            socket.create_connection((host.strip("[]"), int(port)), CONNECT_S) as plain,
            context.wrap_socket(plain) as stream,
        ):
            stream.recv(1)
    except OSError as error:
        return error if isinstance(error, ssl.SSLError) else None
    return None


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    for _ in range(DEPTH):
        if error is None:
            return
        yield error
        error = error.__cause__ or getattr(error, "real_error", None) or error.__context__


def _nobody(address: str) -> str:
    return (
        f"{address}: no Dask scheduler answers within {CONNECT_S:g} s; "
        "start one with `dask scheduler`, or check the address"
    )


def _words(reason: str) -> str:
    return re.sub(
        r" *\(_ssl\.c:\d+\)", "", reason.replace("_", " ").lower() if reason.isupper() else reason
    )
