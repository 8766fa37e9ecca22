"""What an RTSP camera's own reports say of how long its pictures wait."""

from __future__ import annotations

import pytest

from hmi.cameras.sender_clock import SenderClock

SSRC = b"\x00\x00\x00\x07"
EPOCH_S = 3_900_000_000
ANSWER = b"RTSP/1.0 200 OK\r\nCSeq: 5\r\nContent-Length: 3\r\n\r\nyes"


def framed(packet: bytes, channel: int = 0) -> bytes:
    """Return a packet as it goes between the words of RTSP."""
    return b"$" + bytes([channel]) + len(packet).to_bytes(2, "big") + packet


def picture(at_s: float, size: int = 1000) -> bytes:
    """Return a packet of a picture that was taken at a time of the camera."""
    stamp = round(at_s * 90_000) & 0xFFFFFFFF
    return framed(b"\x80\xe0\x00\x01" + stamp.to_bytes(4, "big") + SSRC + bytes(size))


def report(at_s: float) -> bytes:
    """Return what the camera's clock showed when it showed that."""
    ntp = int((EPOCH_S + at_s) * 2**32)
    stamp = round(at_s * 90_000) & 0xFFFFFFFF
    return framed(b"\x80\xc8\x00\x06" + SSRC + ntp.to_bytes(8, "big") + stamp.to_bytes(4, "big") + bytes(8), 1)


def fed(clock: SenderClock, from_s: float, to_s: float, waits_s: float = 0.0) -> None:
    """Let pictures come, 20 a second, each after so long."""
    for number in range(round(from_s * 20), round(to_s * 20)):
        clock.feed(picture(number / 20), (number / 20 + waits_s) * 1000)


def test_pictures_that_pile_up_in_the_camera_are_told_as_old_as_they_are() -> None:
    clock = SenderClock()
    clock.feed(ANSWER + report(0.0), 0.0)
    fed(clock, 0, 5)
    assert clock.waited_ms == pytest.approx(0.0, abs=2.0)
    fed(clock, 5, 8, waits_s=2.5)
    assert clock.waited_ms == pytest.approx(2500.0, abs=2.0)
    fed(clock, 8, 9)
    assert clock.waited_ms == pytest.approx(0.0, abs=2.0)


def test_without_reports_nothing_is_known() -> None:
    clock = SenderClock()
    fed(clock, 0, 2)
    fed(clock, 2, 4, waits_s=3.0)
    assert clock.waited_ms == 0.0


def test_a_camera_whose_time_stamps_run_wrong_is_put_right_by_its_reports() -> None:
    clock = SenderClock()
    for second in range(120):
        wrong_s = second * 0.98  # it counts 2 % too few
        ntp = int((EPOCH_S + second) * 2**32).to_bytes(8, "big")
        stamp = (round(wrong_s * 90_000) & 0xFFFFFFFF).to_bytes(4, "big")
        clock.feed(framed(b"\x80\xc8\x00\x06" + SSRC + ntp + stamp, 1) + picture(wrong_s), second * 1000.0)
    assert clock.waited_ms < 50.0


def test_a_stream_is_read_in_whatever_pieces_it_comes() -> None:
    clock = SenderClock()
    for whole, came_ms in ((report(0.0) + picture(0.0, 60_000) + ANSWER, 100.0), (picture(0.05) + ANSWER, 2150.0)):
        for at in range(0, len(whole), 7):
            clock.feed(whole[at : at + 7], came_ms)
    assert clock.waited_ms == pytest.approx(2000.0, abs=2.0)


@pytest.mark.parametrize(
    "bad", [b"\x00\x01garbage", b"$\x00\x00\x00" * 5, b"RTSP/1.0 200 OK\r\nContent-Length: 99999999\r\n\r\n"]
)
def test_what_is_not_understood_ends_it_without_a_word(bad: bytes) -> None:
    clock = SenderClock()
    clock.feed(report(0.0) + picture(0.0), 0.0)
    clock.feed(bad, 10.0)
    for _ in range(20):
        clock.feed(bytes(65_536), 20.0)
    assert clock.waited_ms == 0.0
    assert len(clock._buffer) <= 200_000


def test_pictures_that_are_sent_out_of_order_hide_no_waiting() -> None:
    clock = SenderClock()
    clock.feed(ANSWER + report(0.0), 0.0)
    order = [0, *(first + step for first in range(0, 300, 3) for step in (3, 1, 2))]  # two between each two others
    for number, frame in enumerate(order):
        waits_s = 0.0 if number < 100 else min(3.0, (number - 100) / 20)
        clock.feed(picture(frame / 20), (number / 20 + waits_s) * 1000)
    assert clock.waited_ms == pytest.approx(3000.0, abs=100.0)
