"""Whom the clients of this process trust when they speak TLS, and why a certificate was not trusted."""

from __future__ import annotations

import ssl
from dataclasses import dataclass
from functools import cache


@dataclass(frozen=True, slots=True)
class Distrust:
    """Why a certificate is not trusted, and what mends it, each a sentence."""

    text: str
    mend: str


_RAN_OUT = Distrust("Its certificate ran out.", "Have it renewed. If it is valid, this machine's clock is wrong.")
_NOT_YET = Distrust("Its certificate is not valid yet.", "Check this machine's clock and the certificate's dates.")
_OTHER_NAME = Distrust(
    "Its certificate is for another name.",
    "Set the address that stands in the certificate, or have one made for this address.",
)
_NO_AUTHORITY = Distrust(
    "Nobody we trust vouches for its certificate.",
    "Name the file of its authority in the settings. If it has one already, the authority there is another.",
)
_REVOKED = Distrust("Its certificate was called back.", "Have a new one made.")
_REASONS = {9: _NOT_YET, 10: _RAN_OUT, 18: _NO_AUTHORITY, 19: _NO_AUTHORITY, 20: _NO_AUTHORITY, 21: _NO_AUTHORITY,
            23: _REVOKED, 62: _OTHER_NAME, 64: _OTHER_NAME}  # fmt: skip
"""By OpenSSL's number (``X509_V_ERR_*``)."""


@cache
def authorities() -> ssl.SSLContext:
    """Return this machine's certificate authorities, loaded once: each loading takes 20 to 80 ms of the loop."""
    return ssl.create_default_context()


def distrust(error: BaseException | None) -> Distrust | None:
    """Return why a certificate was not trusted, however deep in what a client raised; ``None``: it was not that."""
    while error is not None:
        if isinstance(error, ssl.SSLCertVerificationError):
            said = getattr(error, "verify_message", "") or str(error)
            known = _REASONS.get(getattr(error, "verify_code", 0))
            return known or Distrust(f"Its certificate is not trusted: {said}"[:200], "Check the certificate.")
        error = error.__cause__ or error.__context__
    return None


def speaks_no_tls(error: BaseException | None) -> bool:
    """Say whether what answered an https address does not speak TLS."""
    while error is not None:
        if isinstance(error, ssl.SSLError) and error.reason in ("WRONG_VERSION_NUMBER", "RECORD_LAYER_FAILURE"):
            return True
        error = error.__cause__ or error.__context__
    return False
