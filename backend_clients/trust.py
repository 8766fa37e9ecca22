"""Whom the clients of this process trust when they speak TLS."""

from __future__ import annotations

import ssl
from functools import cache


@cache
def authorities() -> ssl.SSLContext:
    """Return this machine's certificate authorities, loaded once: each loading takes 20 to 80 ms of the loop."""
    return ssl.create_default_context()


def is_distrust(error: BaseException | None) -> bool:
    """Say whether a certificate was not trusted, however deep in what a client raised."""
    while error is not None:
        if isinstance(error, ssl.SSLCertVerificationError):
            return True
        error = error.__cause__ or error.__context__
    return False
