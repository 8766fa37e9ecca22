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

from backend_clients.errors import ClientError


class ServiceError(ClientError):
    """Root of all errors of this package.

    Attributes:
        mend: one sentence for whoever has to repair it.
    """

    mend = "Look at the log of the service."


class BadRequest(ServiceError, ValueError):
    """What was asked for can never be sent; nothing was."""

    mend = "Correct the value; the service would refuse it."


class Unreachable(ServiceError):
    """There is no connection, or it broke."""

    mend = "Check that the service runs, its address, the network and the certificate."


class NoAnswer(Unreachable):
    """No answer in time."""

    mend = "Check the load of the service and the delay of the network."


class Untrusted(Unreachable):
    """Its certificate is not to be trusted; nothing was sent."""

    mend = "Check the certificate's name and dates and this machine's clock, or name its authority in the settings."


class Unreadable(ServiceError):
    """What came cannot be trusted to mean what it says."""

    mend = "Check that the address is that of the service and not of a proxy's page, and that both speak one version."


class TooLong(Unreadable):
    """More came than the limit allows; the rest was not read."""


class ServiceRefused(ServiceError):
    """The service answered with an error.

    Args:
        status: HTTP status.
        text: the service's sentence, shortened.

    Attributes:
        retry_after_s: how long it asks to wait, seconds.
    """

    retry_after_s: float | None = None

    def __init__(self, status: int, text: str) -> None:
        super().__init__(f"{status}: {text}" if text else f"{status}")
        self.status, self.text = status, text


class NotAllowed(ServiceRefused):
    """The token is missing, out of date or does not allow this."""

    mend = "Check the token."


class Gone(ServiceRefused):
    """There is no such thing there, or not any more."""

    mend = "Check the address of the service."


class TooLarge(ServiceRefused):
    """The request is larger than the service, or a proxy before it, takes."""

    mend = "Raise the limit of the service or of the proxy before it."


class Busy(ServiceRefused):
    """It asks for fewer requests."""

    mend = "Wait; it is asked again by itself."


class ServiceFailed(ServiceRefused):
    """The service or a proxy before it failed."""

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


def is_passing(error: ServiceError) -> bool:
    """Say whether the same request may succeed a little later."""
    if isinstance(error, Unreachable | Busy):
        return not isinstance(error, Untrusted)
    return isinstance(error, ServiceFailed) and error.status in (500, 502, 503, 504)
