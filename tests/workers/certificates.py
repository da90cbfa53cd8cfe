"""Certificates for a cluster on the loopback, made as docs/theory/cluster.md says."""

from __future__ import annotations

import subprocess
from pathlib import Path

ROLES = ("scheduler", "worker", "client")


def certificates(folder: Path) -> dict[str, str]:
    """Dask's settings with an authority, a certificate and its key, made in `folder` by openssl."""
    folder.mkdir()
    new = ("req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
    signed = (
        "x509",
        "-req",
        "-in",
        "request.pem",
        "-CA",
        "ca.pem",
        "-CAkey",
        "ca-key.pem",
        "-CAcreateserial",
        "-days",
        "2",
    )
    for arguments in (
        (
            *new,
            "-x509",
            "-days",
            "2",
            "-subj",
            f"/CN={folder.name} cluster",
            "-keyout",
            "ca-key.pem",
            "-out",
            "ca.pem",
        ),
        (*new, "-subj", "/CN=bench", "-keyout", "key.pem", "-out", "request.pem"),
        (*signed, "-out", "cert.pem"),
    ):
        subprocess.run(
            ("openssl", *arguments), cwd=folder, check=True, capture_output=True, timeout=60
        )
    settings = {
        "distributed.comm.tls.ca-file": str(folder / "ca.pem"),
        "distributed.comm.require-encryption": "true",
    }
    for role in ROLES:
        settings |= {
            f"distributed.comm.tls.{role}.{part}": str(folder / f"{part}.pem")
            for part in ("cert", "key")
        }
    return settings
