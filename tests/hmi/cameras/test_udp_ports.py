"""WebRTC stays in the UDP ports it was given, and says so when there are no more."""

from __future__ import annotations

import asyncio
import re
import socket
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from aiortc import RTCConfiguration, RTCPeerConnection

from hmi.cameras.udp_ports import loop_maker
from hmi.settings import port_range


def run(ports: range, work: Callable[[], Awaitable[Any]]) -> Any:
    with asyncio.Runner(loop_factory=loop_maker(ports)) as runner:

        async def main() -> Any:
            return await work()

        return runner.run(main())


def free_range(count: int) -> range:
    """Return ports that nobody uses now."""
    for first in range(42_000, 60_000, count):
        try:
            for port in range(first, first + count):
                with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as tried:
                    tried.bind(("0.0.0.0", port))
        except OSError:
            continue
        return range(first, first + count)
    raise AssertionError("no free UDP ports")


def test_every_candidate_of_an_answer_lies_in_the_range() -> None:
    ports = free_range(8)

    async def gather() -> str:
        peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        peer.createDataChannel("any")
        await peer.setLocalDescription(await peer.createOffer())
        sdp: str = peer.localDescription.sdp
        await peer.close()
        return sdp

    found = [int(port) for port in re.findall(r"^a=candidate:\S+ \d+ udp \d+ \S+ (\d+)", run(ports, gather), re.M)]
    assert found
    assert set(found) <= set(ports)


def test_ports_are_taken_in_turn_and_the_one_too_many_is_refused() -> None:
    ports = free_range(2)

    async def take() -> list[int]:
        loop, places, open_ones = asyncio.get_running_loop(), [], []
        for _ in range(2):
            transport, _ = await loop.create_datagram_endpoint(asyncio.DatagramProtocol, local_addr=("127.0.0.1", 0))
            places.append(transport.get_extra_info("sockname")[1])
            open_ones.append(transport)
        with pytest.raises(OSError, match="all UDP ports"):
            await loop.create_datagram_endpoint(asyncio.DatagramProtocol, local_addr=("127.0.0.1", 0))
        for transport in open_ones:
            transport.close()
        return places

    assert run(ports, take) == list(ports)


@pytest.mark.parametrize("text", ["40000", "40100-40000", "80-90", "a-b", "40000-70000", "40000-"])
def test_what_is_no_range_is_refused_in_words(text: str) -> None:
    with pytest.raises(ValueError, match="two ports from 1024 to 65535"):
        port_range(text)
    assert port_range("") is None
