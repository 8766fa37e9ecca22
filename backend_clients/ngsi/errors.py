"""What can go wrong with a context broker, and how to mend it.

::

    NgsiError
    ├── BadInput               refused here, nothing was sent
    ├── Unreachable            no connection, or it broke
    │   ├── NoAnswer           no answer in time
    │   └── Untrusted          its certificate is not to be trusted
    ├── NoToken                the token service gave none
    ├── Unreadable             the answer, or a notification, is not what NGSI-v2 promises
    │   └── TooLong            it is longer than the limit
    └── BrokerRefused          the broker answered and said no
        ├── NotFound           404
        ├── Ambiguous          409: the id stands for several types
        ├── NotApplied         422: nothing of it took effect
        │   └── AlreadyExists  422
        ├── PartlyApplied      422: some of it took effect
        ├── TooLarge           413
        ├── NotAllowed         401, 403
        ├── Overloaded         429
        └── BrokerFailed       5xx
"""

from __future__ import annotations

from backend_clients.http.exchange import ExchangeFailed
from backend_clients.http.trouble import OutsideError, Trouble


class NgsiError(OutsideError):
    """Root of all errors of this package.

    Attributes:
        mend: one sentence for whoever has to repair it.
        attempts: how often the request was sent.
        is_outcome_unknown: a write may have taken effect, now or in an earlier attempt.
    """

    mend = "Look at the broker's log with the correlator of this request."
    attempts = 1
    is_outcome_unknown = False


class BadInput(NgsiError, ValueError):
    """What was asked for can never be sent; nothing was."""

    trouble = Trouble.MISSET
    mend = "Correct the value; the broker would refuse it."


class Unreachable(NgsiError):
    """There is no connection to the broker, or it broke.

    Args:
        text: what failed.
        is_outcome_unknown: the request may have taken effect.
    """

    trouble = Trouble.UNREACHABLE
    mend = "Check that the broker runs, its address, the network and the certificate."

    def __init__(self, text: str, *, is_outcome_unknown: bool = False) -> None:
        super().__init__(text)
        self.is_outcome_unknown = is_outcome_unknown


class NoAnswer(Unreachable):
    """The broker did not answer in time."""

    trouble = Trouble.SILENT
    mend = "Check the load of the broker and its database, and the delay of the network."


class Untrusted(Unreachable):
    """The broker's certificate is not to be trusted; nothing was sent."""

    trouble = Trouble.UNTRUSTED
    mend = "Check the certificate's name and dates, or name its authority in the settings."


class NoToken(NgsiError):
    """The token service gave no token; nothing was sent to the broker. ``trouble`` is that of the way to it."""

    trouble = Trouble.REFUSED
    mend = "Check the address of the token service, the client id and the secrets."


class Unreadable(NgsiError):
    """What came cannot be trusted to mean what it says."""

    trouble = Trouble.NOT_UNDERSTOOD
    mend = "Check that the address is that of an NGSI-v2 broker and not of a proxy's page."


class TooLong(Unreadable):
    """More came than the limit allows; the rest was not read."""

    mend = "Ask for fewer attributes or smaller pages."


class BrokerRefused(NgsiError):
    """The broker answered with an error.

    Args:
        status: HTTP status.
        error: the broker's error word.
        description: the broker's sentence, shortened.
        correlator: what the broker's log calls this request.

    Attributes:
        is_of_proxy: not a broker's words, so of what stands before it.
    """

    is_of_proxy = False

    def __init__(self, status: int, error: str, description: str, correlator: str) -> None:
        super().__init__(f"{status} {error}: {description} [{correlator}]")
        self.status, self.error, self.description, self.correlator = status, error, description, correlator


class NotFound(BrokerRefused):
    """There is no such entity, attribute or subscription in this tenant and path."""

    mend = "Check id, type, tenant and service path."


class Ambiguous(BrokerRefused):
    """The id stands for entities of several types."""

    mend = "Name the type."


class NotApplied(BrokerRefused):
    """The request was understood and nothing of it took effect."""

    mend = "Read the entity again and decide anew."


class AlreadyExists(NotApplied):
    """There is such an entity already."""

    mend = "Use upsert, or another id."


class PartlyApplied(BrokerRefused):
    """Some attributes were written, those in ``missed`` were not."""

    mend = "Read the entity again; append what is missing."
    missed: tuple[str, ...] = ()


class TooLarge(BrokerRefused):
    """The body is larger than the broker or a proxy before it takes, or has a second location."""

    mend = "Raise the limit of a proxy before the broker; give a second location the metadata ignoreType."


class NotAllowed(BrokerRefused):
    """The token is missing, out of date or does not allow this."""

    trouble = Trouble.REFUSED
    mend = "Check the credentials and what they allow in this tenant."


class Overloaded(BrokerRefused):
    """The broker, or a proxy before it, asks for fewer requests."""

    trouble = Trouble.BUSY
    mend = "Send less often."


class BrokerFailed(BrokerRefused):
    """The broker, its database or a proxy before it failed; whether a write took effect is unknown."""

    trouble = Trouble.FAILING
    mend = "Check the broker and its database."
    is_outcome_unknown = True


def refusal(status: int, error: str, description: str, correlator: str) -> BrokerRefused:
    """Return the error for an answer of the broker."""
    kinds: dict[int, type[BrokerRefused]] = {
        401: NotAllowed,
        403: NotAllowed,
        404: NotFound,
        409: Ambiguous,
        413: TooLarge,
        429: Overloaded,
    }
    kind = BrokerFailed if status >= 500 else kinds.get(status, BrokerRefused)
    if status == 422:
        kind = PartlyApplied if error == "PartialUpdate" else NotApplied
        kind = AlreadyExists if "Already Exists" in description else kind
    found = kind(status, error, description, correlator)
    if isinstance(found, PartlyApplied):
        found.missed = _names(description)
    return found


def failure(failed: ExchangeFailed) -> NgsiError:
    """Return the error for an exchange that brought nothing usable."""
    kinds: dict[Trouble, type[NgsiError]] = {
        Trouble.SILENT: NoAnswer,
        Trouble.UNTRUSTED: Untrusted,
        Trouble.NOT_UNDERSTOOD: TooLong if failed.is_too_long else Unreadable,
    }
    found = kinds.get(failed.trouble, Unreachable)(f"{failed}")
    found.is_outcome_unknown = failed.has_left
    found.mend = failed.mend or found.mend
    return found


def _names(description: str) -> tuple[str, ...]:
    """Return the attributes of ``do not exist: r1 - [ a, b ]``."""
    _, _, rest = description.partition("[")
    names, closed, _ = rest.rpartition("]")
    return tuple(name.strip() for name in names.split(",")) if closed and names.strip() else ()
