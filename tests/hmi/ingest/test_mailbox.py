"""Between the network thread and the loop nothing is lost silently and nothing grows without end."""

from __future__ import annotations

import asyncio
import threading

from hypothesis import given
from hypothesis import strategies as st

from hmi.ingest.mailbox import Mailbox

STATE, ACK = "headland/v1/weeder-01/state", "headland/v1/weeder-01/ack"


class Waker:
    """A loop that only counts how often it is called."""

    def __init__(self) -> None:
        self.calls = 0

    def call_soon_threadsafe(self, _callback: object) -> None:
        """Count."""
        self.calls += 1


def box(waker: Waker | None = None, **limits: int) -> Mailbox:
    """Return a mailbox on a fake loop."""
    return Mailbox(waker or Waker(), lambda: None, lambda: 1.0, **limits)  # type: ignore[arg-type]


def test_only_the_newest_state_of_a_robot_waits() -> None:
    mailbox = box()
    for number in range(5):
        mailbox.post(STATE, b"%d" % number, False)
    assert [letter.payload for letter in mailbox.take().state] == [b"4"]


def test_acknowledgements_wait_in_order_and_none_is_conflated() -> None:
    mailbox = box()
    for number in range(5):
        mailbox.post(ACK, b"%d" % number, False)
    assert [letter.payload for letter in mailbox.take().discrete] == [b"0", b"1", b"2", b"3", b"4"]


def test_overflow_drops_the_oldest_and_is_counted() -> None:
    mailbox = box(fifo_limit=3)
    for number in range(5):
        mailbox.post(ACK, b"%d" % number, False)
    batch = mailbox.take()
    assert [letter.payload for letter in batch.discrete] == [b"2", b"3", b"4"]
    assert batch.lost == 2
    assert mailbox.take().lost == 0


def test_invented_robots_cannot_fill_the_memory() -> None:
    mailbox = box(key_limit=10)
    for number in range(1000):
        mailbox.post(f"headland/v1/robot-{number}/telemetry", b"{}", False)
    batch = mailbox.take()
    assert len(batch.state) == 10
    assert batch.refused == {"too_many_keys": 990}


def test_the_loop_is_called_once_a_batch() -> None:
    waker = Waker()
    mailbox = box(waker)
    for _ in range(100):
        mailbox.post(STATE, b"", False)
    assert waker.calls == 1
    mailbox.take()
    mailbox.post(STATE, b"", False)
    assert waker.calls == 2


def test_what_is_left_waits_in_its_order_and_is_not_called_for_again() -> None:
    waker = Waker()
    mailbox = box(waker)
    for number in range(5):
        mailbox.post(ACK, b"%d" % number, False)
        mailbox.post(f"headland/v1/robot-{number}/state", b"old", False)
    first = mailbox.take(3)
    assert [letter.payload for letter in first.discrete] == [b"0", b"1", b"2"]
    assert [letter.address.robot for letter in first.state] == ["robot-0", "robot-1", "robot-2"]
    assert first.is_more
    mailbox.post("headland/v1/robot-0/state", b"newest", False)
    mailbox.post("headland/v1/robot-4/state", b"newest", False)
    assert waker.calls == 1, "whoever left something comes again by itself"
    rest = mailbox.take(3)
    assert [letter.payload for letter in rest.discrete] == [b"3", b"4"]
    assert [(letter.address.robot, letter.payload) for letter in rest.state] == [
        ("robot-3", b"old"), ("robot-4", b"newest"), ("robot-0", b"newest"),
    ]  # fmt: skip
    assert not rest.is_more


def test_everything_that_five_thousand_robots_say_at_one_time_is_kept() -> None:
    mailbox = box()
    kinds = ("factsheet", "heartbeat", "telemetry", "state", "safety")
    for number in range(5000):
        for kind in kinds:
            mailbox.post(f"headland/v1/robot-{number}/{kind}", b"{}", True)
    batch = mailbox.take()
    assert (len(batch.state), batch.refused) == (5000 * len(kinds), {})


def test_a_topic_of_the_console_is_refused() -> None:
    mailbox = box()
    mailbox.post("headland/v1/weeder-01/command", b"{}", False)
    assert mailbox.take().refused == {"bad_topic": 1}


@given(topic=st.text(max_size=200), payload=st.binary(max_size=200))
def test_no_topic_and_no_payload_harms_the_network_thread(topic: str, payload: bytes) -> None:
    mailbox = box()
    mailbox.post(topic, payload, False)
    batch = mailbox.take()
    assert len(batch.discrete) + len(batch.state) + sum(batch.refused.values()) == 1


def test_posting_after_the_loop_has_ended_does_not_raise() -> None:
    loop = asyncio.new_event_loop()
    loop.close()
    mailbox = Mailbox(loop, lambda: None, lambda: 1.0)
    mailbox.post(STATE, b"", False)
    mailbox.post(STATE, b"", False)


async def test_a_thousand_messages_of_another_thread_arrive() -> None:
    got: list[bytes] = []
    done = asyncio.Event()

    def on_mail() -> None:
        got.extend(letter.payload for letter in mailbox.take().discrete)
        if len(got) == 1000:
            done.set()

    mailbox = Mailbox(asyncio.get_running_loop(), on_mail, lambda: 1.0)
    thread = threading.Thread(target=lambda: [mailbox.post(ACK, b"%d" % i, False) for i in range(1000)])
    thread.start()
    async with asyncio.timeout(5):
        await done.wait()
    thread.join()
    assert got == [b"%d" % i for i in range(1000)]
