"""The errors of the STOP gateway.

::

    GatewayError
    ├── BadFrame          a browser sent something that is not of the protocol
    ├── TokenRefused      the STOP token is not ours, or its tablet was revoked
    ├── TooManyRobots     more robots than any farm has, most of them never heard of
    └── PortTaken         the gateway's port belongs to another program
"""

from __future__ import annotations


class GatewayError(Exception):
    """Root of all errors raised by ``hmi.stop_gateway``; ``code`` is stable, ``text`` is for a person."""

    code = "error"

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.text = text


class BadFrame(GatewayError):
    """A frame or body is not of the protocol."""

    code = "bad_frame"


class TokenRefused(GatewayError):
    """The STOP token is not ours, or its tablet was revoked."""

    code = "bad_token"


class TooManyRobots(GatewayError):
    """A press names more unknown robots than the gateway keeps."""

    code = "too_many_robots"


class PortTaken(GatewayError):
    """The port belongs to another program."""

    code = "port_taken"
