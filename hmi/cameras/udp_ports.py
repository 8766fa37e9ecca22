"""An event loop whose UDP sockets take ports out of a range, so that a firewall can be told which.

The WebRTC library asks its loop for any free port and has no setting of its own.
"""

from __future__ import annotations

import asyncio
import errno
from collections.abc import Callable
from typing import Any


class RangedLoop(asyncio.SelectorEventLoop):
    """As usual, but ``create_datagram_endpoint`` for port 0 takes the next free port of ``ports``."""

    def __init__(self, ports: range) -> None:
        super().__init__()
        self._ports, self._turn = ports, 0

    async def create_datagram_endpoint(  # type: ignore[override]  # its many types are asyncio's business
        self, protocol_factory: Callable[[], Any], local_addr: Any = None, **more: Any
    ) -> tuple[Any, Any]:
        """See ``asyncio``; raises ``OSError`` when every port is in use."""
        if not local_addr or local_addr[1]:
            return await super().create_datagram_endpoint(protocol_factory, local_addr=local_addr, **more)
        for _ in self._ports:
            place = (local_addr[0], self._ports[self._turn % len(self._ports)])
            self._turn += 1  # in turn: what still comes for a stream that ended meets no new one
            try:
                return await super().create_datagram_endpoint(protocol_factory, local_addr=place, **more)
            except OSError as error:
                if error.errno != errno.EADDRINUSE:
                    raise
        raise OSError(errno.EADDRINUSE, f"all UDP ports from {self._ports[0]} to {self._ports[-1]} are in use")


def loop_maker(ports: range | None) -> Callable[[], asyncio.AbstractEventLoop]:
    """Return what makes the loop of the camera process; ``None`` lets the system choose ports."""
    return asyncio.new_event_loop if ports is None else lambda: RangedLoop(ports)
