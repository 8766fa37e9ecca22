"""Stays in states as REST carries them."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

from hmi.domain.state_share import Sums
from hmi.domain.state_times import Interval
from hmi.presenters.state_times import MOST_SHOWN, state_times

START = datetime(2026, 3, 1, 6, tzinfo=UTC)


def test_of_more_stays_than_are_shown_the_longest_come_and_it_is_said_how_many_there_are() -> None:
    seconds = [1.0] * 300 + [2.0] * MOST_SHOWN
    stays, at = [], START
    for length in seconds:
        stays.append(Interval("plant", "Plant", "Crane", ("plant",), True, at, at + timedelta(seconds=length)))
        at += timedelta(seconds=length)
    told = state_times(stays, Sums((), (), 0.0, 0.0), None, (START, at), (at, 10.0))
    assert (told["is_thinned"], told["stays"], len(told["intervals"])) == (True, MOST_SHOWN + 300, MOST_SHOWN)
    assert {one["end"] - one["start"] for one in told["intervals"]} == {2000}
    few = state_times(stays[:5], Sums((), (), 0.0, 0.0), None, (START, at), (at, 10.0))
    assert (few["is_thinned"], few["stays"]) == (False, 5)
