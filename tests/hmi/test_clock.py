"""The machine's clock: what was true before it slept is old when it wakes."""

from __future__ import annotations

import time

import pytest

from hmi import clock
from hmi.cameras import pull_http
from hmi.clock import SystemClock

SLEPT_S = 3600.0


@pytest.mark.skipif(not hasattr(time, "CLOCK_BOOTTIME"), reason="only Linux has this clock")
def test_the_clock_of_every_process_goes_on_while_the_machine_sleeps(monkeypatch: pytest.MonkeyPatch) -> None:
    slept = {time.CLOCK_MONOTONIC: 10.0, time.CLOCK_BOOTTIME: 10.0 + SLEPT_S}
    monkeypatch.setattr(time, "clock_gettime", slept.__getitem__)
    monkeypatch.setattr(time, "monotonic", lambda: 10.0)
    assert SystemClock().mono_s() == 10.0 + SLEPT_S
    assert pull_http._now_ms() == (10.0 + SLEPT_S) * 1000  # pictures are judged by other processes


def test_where_there_is_no_such_clock_the_monotonic_one_serves(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clock, "_BOOT_TIME", None)
    monkeypatch.setattr(time, "monotonic", lambda: 10.0)
    assert SystemClock().mono_s() == 10.0
