"""A broker, a robot or a listener that fails, and bytes that mean nothing, end the hearing of nobody."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from backend_clients.edge.codec import encode
from backend_clients.edge.mqtt import LinkState
from backend_clients.edge.topics import Up
from hmi.domain.command import Acknowledgement
from hmi.ingest import coordinator
from hmi.ingest.coordinator import LETTERS_A_TURN
from tests.hmi.ingest.wire import FakeWireRobot, Rig

ID = "weeder-01"


async def test_a_listener_that_fails_harms_no_other() -> None:
    async with Rig(ID) as rig:
        acks: list[Acknowledgement] = []

        def fail(_ack: Acknowledgement) -> None:
            raise RuntimeError("no")

        rig.edge.listeners.on_ack.extend([fail, acks.append])
        rig.say(rig.robot().ack())
        assert len(acks) == 1


async def test_a_dead_network_thread_is_revived_and_reported() -> None:
    async with Rig(ID) as rig:
        troubles: list[str] = []
        rig.edge.listeners.on_trouble.append(lambda code, _text: troubles.append(code))
        rig.link.is_alive = False
        rig.edge.look_after()
        assert rig.link.is_alive
        assert rig.link.starts == 2
        assert troubles == ["ingest_thread"]


async def test_a_network_thread_that_cannot_be_started_is_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coordinator, "WATCH_S", 0.001)
    async with Rig(ID) as rig:
        start, is_refused, is_back = rig.link.start, asyncio.Event(), asyncio.Event()

        def no_room() -> None:
            is_refused.set()
            raise RuntimeError("can't start new thread")

        rig.link.is_alive, rig.link.start = False, no_room  # type: ignore[method-assign]
        await asyncio.wait_for(is_refused.wait(), 5)
        rig.link.start = lambda: (start(), is_back.set())  # type: ignore[assignment, method-assign, func-returns-value]
        await asyncio.wait_for(is_back.wait(), 5)
        assert rig.link.is_alive


async def test_losing_the_broker_shows_on_every_robot() -> None:
    async with Rig(ID) as rig:
        assert rig.store.robot(ID).link.is_broker_up  # type: ignore[union-attr]
        rig.link.on_link(LinkState.DOWN, "connection refused")
        await asyncio.sleep(0)
        assert not rig.store.robot(ID).link.is_broker_up  # type: ignore[union-attr]
        assert rig.edge.broker_text == "connection refused"


async def test_overflow_is_reported_as_trouble() -> None:
    async with Rig(ID, fifo_limit=5) as rig:
        troubles: list[str] = []
        rig.edge.listeners.on_trouble.append(lambda code, _text: troubles.append(code))
        for _ in range(10):
            rig.post(rig.robot().ack())
        rig.edge.drain()
        assert troubles == ["ingest_overflow"]
        assert rig.edge.tally.total["overflow"] == 5


async def test_a_crowd_of_robots_lets_others_have_the_loop_between_and_is_heard_all_the_same() -> None:
    crowd = [f"weeder-{n:04d}" for n in range(3 * LETTERS_A_TURN)]
    async with Rig(*crowd) as rig:
        for robot_id in crowd:
            rig.post(rig.robot(robot_id).heartbeat())
        heard_when_others_ran = []
        async with asyncio.timeout(5):
            while rig.edge.messages < len(crowd):
                await asyncio.sleep(0)
                heard_when_others_ran.append(rig.edge.messages)
        assert any(0 < heard < len(crowd) for heard in heard_when_others_ran)
        assert all(robot.link.is_online for robot in rig.store.robots())


@pytest.mark.parametrize(
    ("payload", "reason"),
    [
        (b"", "malformed"),
        (b"{", "malformed"),
        (b"\xff\xfe", "malformed"),
        (b"[" * 50_000, "malformed"),
        (b'{"speed_mps": NaN}', "malformed"),
        (b'{"v": 2}', "malformed"),
        (b" " * 100_000, "oversized"),
    ],
)
async def test_a_bad_payload_is_counted_by_reason_and_robot(payload: bytes, reason: str) -> None:
    async with Rig(ID) as rig:
        rig.link.on_message(f"headland/v1/{ID}/telemetry", payload, False)
        rig.edge.drain()
        assert rig.edge.diagnostics()["refused_by_robot"] == {ID: {reason: 1}}
        rig.say(rig.robot().telemetry())
        assert rig.store.robot(ID).telemetry is not None  # type: ignore[union-attr]


async def test_a_robot_cannot_speak_for_another() -> None:
    async with Rig(ID, "weeder-02") as rig:
        payload = encode(rig.robot("weeder-02").safety(standstill=True))
        rig.link.on_message(f"headland/v1/{ID}/safety", payload, False)
        rig.edge.drain()
        assert rig.store.robot(ID).safety is None  # type: ignore[union-attr]
        assert rig.edge.tally.total["wrong_identity"] == 1


def nearly_honest() -> st.SearchStrategy[bytes]:
    """Return honest messages with one value replaced by anything JSON can say."""
    anything = st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=20),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
        max_leaves=6,
    )
    rig = Rig()
    robot = rig.robot()
    honest = [
        json.loads(encode(m))
        for m in (robot.telemetry(), robot.state(), robot.safety(), robot.heartbeat(), robot.event(), robot.ack())
    ]

    def spoil(message: dict[str, Any], key: int, value: Any) -> bytes:
        spoiled = dict(message)
        spoiled[sorted(spoiled)[key % len(spoiled)]] = value
        return json.dumps(spoiled).encode()

    return st.builds(spoil, st.sampled_from(honest), st.integers(0, 40), anything)


@hypothesis_settings(max_examples=150, deadline=None)
@given(
    frames=st.lists(
        st.tuples(
            st.one_of(
                st.sampled_from([f"headland/v1/{ID}/{k.value}" for k in Up]),
                st.text(max_size=40),
                st.sampled_from(["$SYS/broker", "headland/v1//state", "headland/v1/../state", "headland/v2/a/state"]),
            ),
            st.one_of(st.binary(max_size=300), nearly_honest()),
            st.booleans(),
        ),
        max_size=20,
    )
)
@pytest.mark.slow
async def test_any_bytes_on_any_topic_are_survived(frames: list[tuple[str, bytes, bool]]) -> None:
    async with Rig(ID) as rig:
        for topic, payload, is_retained in frames:
            rig.link.on_message(topic, payload, is_retained)
            rig.edge.drain()
        assert rig.edge.tally.total["internal_error"] == 0
        rig.clock.advance(10)  # whatever was believed of a clock is forgotten after a silence
        honest = FakeWireRobot(ID, rig.clock, boot="boot-honest")
        rig.say(honest.safety(latched=True))
        assert rig.store.robot(ID).safety.latched  # type: ignore[union-attr]


async def test_a_fault_of_somebody_who_is_told_ends_the_hearing_of_no_robot() -> None:
    crowd = [f"weeder-{n:04d}" for n in range(2 * LETTERS_A_TURN)]
    async with Rig(*crowd) as rig:
        told: list[int] = []

        def fails_once() -> None:
            told.append(rig.edge.messages)
            if len(told) == 1:
                raise RuntimeError("the disk is full")

        rig.store.subscribe(fails_once)
        for robot_id in crowd:
            rig.post(rig.robot(robot_id).heartbeat())
        await _heard(rig, len(crowd))
        rig.post(rig.robot(crowd[0]).telemetry())
        await _heard(rig, len(crowd) + 1)
        assert len(told) > 1, "who failed is told again"
        assert all(rig.store.is_online(robot_id) for robot_id in crowd)


async def test_a_turn_that_fails_as_a_whole_is_followed_by_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    crowd = [f"weeder-{n:04d}" for n in range(2 * LETTERS_A_TURN)]
    async with Rig(*crowd) as rig:
        announce, failed = rig.store.announce, []

        def fails_once() -> None:
            if not failed:
                failed.append(True)
                raise RuntimeError("a fault of ours")
            announce()

        monkeypatch.setattr(rig.store, "announce", fails_once)
        asyncio.get_running_loop().set_exception_handler(lambda *_: None)
        for robot_id in crowd:
            rig.post(rig.robot(robot_id).heartbeat())
        await _heard(rig, len(crowd))
        assert failed
        assert all(rig.store.is_online(robot_id) for robot_id in crowd)


async def _heard(rig: Rig, messages: int) -> None:
    """Wait until so many were applied."""
    async with asyncio.timeout(5):
        while rig.edge.messages < messages:  # noqa: ASYNC110 - nobody is told of a message
            await asyncio.sleep(0.01)
