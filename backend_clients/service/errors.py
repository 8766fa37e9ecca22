"""What can go wrong with a service, and how to mend it.

::

    ServiceError
    ├── BadRequest             refused here, nothing was sent
    ├── Unreachable            no connection, or it broke
    │   ├── NoAnswer           no answer in time
    │   └── Untrusted          its certificate is not to be trusted
    ├── Unreadable             the answer is not what the format promises
    │   └── TooLong            it is longer than the limit
    └── ServiceRefused         the service answered and said no
        ├── NotAllowed         401, 403
        ├── Gone               404, 410
        ├── TooLarge           413
        ├── Busy               429
        └── ServiceFailed      5xx
"""

from __future__ import annotations

from backend_clients.http.exchange import ExchangeFailed
from backend_clients.http.trouble import OutsideError, Trouble


class ServiceError(OutsideError):
    """Root of all errors of this package."""


class BadRequest(ServiceError, ValueError):
    """What was asked for can never be sent; nothing was."""

    trouble = Trouble.MISSET
    mend = "Correct the value; the service would refuse it."


class Unreachable(ServiceError):
    """There is no connection, or it broke."""

    trouble = Trouble.UNREACHABLE
    mend = "Check that the service runs, its address, the network and the certificate."


class NoAnswer(Unreachable):
    """No answer in time."""

    trouble = Trouble.SILENT
    mend = "Check the load of the service and the delay of the network."


class Untrusted(Unreachable):
    """Its certificate is not to be trusted; nothing was sent."""

    trouble = Trouble.UNTRUSTED
    mend = "Check the certificate's name and dates and this machine's clock, or name its authority in the settings."


class Unreadable(ServiceError):
    """What came cannot be trusted to mean what it says."""

    trouble = Trouble.NOT_UNDERSTOOD
    mend = "Check that the address is that of the service and not of a proxy's page, and that both speak one version."


class TooLong(Unreadable):
    """More came than the limit allows; the rest was not read."""


class ServiceRefused(ServiceError):
    """The service answered with an error.

    Args:
        status: HTTP status.
        text: the service's sentence, shortened.
    """

    def __init__(self, status: int, text: str) -> None:
        super().__init__(f"{status}: {text}" if text else f"{status}")
        self.status, self.text = status, text


class NotAllowed(ServiceRefused):
    """The token is missing, out of date or does not allow this."""

    trouble = Trouble.REFUSED
    mend = "Check the token."


class Gone(ServiceRefused):
    """There is no such thing there, or not any more."""

    mend = "Check the address of the service."


class TooLarge(ServiceRefused):
    """The request is larger than the service, or a proxy before it, takes."""

    mend = "Raise the limit of the service or of the proxy before it."


class Busy(ServiceRefused):
    """It asks for fewer requests."""

    trouble = Trouble.BUSY
    mend = "Wait; it is asked again by itself."


class ServiceFailed(ServiceRefused):
    """The service or a proxy before it failed."""

    trouble = Trouble.FAILING
    mend = "Look at the log of the service."


def refusal(status: int, text: str) -> ServiceRefused:
    """Return the error for an answer of a service."""
    kinds: dict[int, type[ServiceRefused]] = {
        401: NotAllowed,
        403: NotAllowed,
        404: Gone,
        410: Gone,
        413: TooLarge,
        429: Busy,
    }
    kind = ServiceFailed if status >= 500 else kinds.get(status, ServiceRefused)
    return kind(status, text)


def failure(failed: ExchangeFailed) -> ServiceError:
    """Return the error for an exchange that brought nothing usable."""
    kinds: dict[Trouble, type[ServiceError]] = {
        Trouble.SILENT: NoAnswer,
        Trouble.UNTRUSTED: Untrusted,
        Trouble.NOT_UNDERSTOOD: TooLong if failed.is_too_long else Unreadable,
    }
    found = kinds.get(failed.trouble, Unreachable)(f"{failed}")
    found.mend = failed.mend or found.mend
    return found
