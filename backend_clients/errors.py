"""The errors of every client in this package.

::

    ClientError
    ├── WireError                a payload that cannot be trusted
    │   ├── MalformedPayload     not JSON, wrong type, out of range, NaN, unknown version
    │   ├── OversizedPayload     larger than the limit of its topic
    │   └── WrongIdentity        topic and payload name different robots, or a bad id
    └── TransportError           nothing, or nothing usable, came back
        ├── NotConnected         refused at once: nothing is queued for later
        ├── TimedOut             the outcome is unknown
        └── Refused              the other side answered with a reason
"""

from __future__ import annotations


class ClientError(Exception):
    """Root of all errors raised by ``backend_clients``."""


class WireError(ClientError):
    """A payload from outside cannot be trusted."""


class MalformedPayload(WireError):
    """The payload is not what its topic promises."""


class OversizedPayload(WireError):
    """The payload is larger than its topic allows."""


class WrongIdentity(WireError):
    """Topic and payload name different robots, or the id breaks the id rule."""


class TransportError(ClientError):
    """The other side could not be reached or did not answer usefully."""


class NotConnected(TransportError):
    """There is no connection now; the message was dropped, not queued."""


class TimedOut(TransportError):
    """No answer in time; whether it took effect is unknown."""


class Refused(TransportError):
    """The other side answered and refused.

    Args:
        code: stable machine-readable reason, e.g. ``stale_challenge``.
        text: one sentence for a person.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(f"{code}: {text}")
        self.code = code
        self.text = text
