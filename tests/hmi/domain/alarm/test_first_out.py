"""One cause is one line; nothing is lost and nothing stands twice."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.alarm.alarm import Alarm, AlarmKey, Phase
from hmi.domain.alarm.catalogue import catalogue, follows_from
from hmi.domain.alarm.first_out import first_outs

T0 = datetime(2026, 5, 20, 14, 36, 40, tzinfo=UTC)


def raised(code: str, after_s: float, source: str = "weeder-07") -> Alarm:
    """Give an alarm raised ``after_s`` seconds after the beginning."""
    return Alarm(AlarmKey(code, source), phase=Phase.UNACKNOWLEDGED, raised_at=T0 + timedelta(seconds=after_s))


def test_what_follows_from_a_lost_link_stands_under_it() -> None:
    groups = first_outs(
        [raised("stop-not-confirmed", 1), raised("link-lost", 0), raised("values-old", 0.9)], follows_from
    )
    assert [one.first.key.code for one in groups] == ["link-lost"]
    assert [one.key.code for one in groups[0].follows] == ["values-old", "stop-not-confirmed"]


def test_what_came_long_before_its_supposed_cause_is_a_cause_of_its_own() -> None:
    groups = first_outs([raised("stop-not-confirmed", 0), raised("link-lost", 5)], follows_from)
    assert [one.first.key.code for one in groups] == ["stop-not-confirmed", "link-lost"]


def test_robots_do_not_explain_each_other() -> None:
    groups = first_outs([raised("link-lost", 0, "weeder-01"), raised("values-old", 1, "weeder-02")], follows_from)
    assert len(groups) == 2


def test_a_chain_ends_under_the_first_also_when_it_was_noticed_in_the_wrong_order() -> None:
    chain = {"a": frozenset(), "b": frozenset({"a"}), "c": frozenset({"b"}), "d": frozenset({"c"})}
    alarms = [raised("d", 0.0), raised("c", 0.1), raised("b", 0.2), raised("a", 0.3)]
    groups = first_outs(alarms, lambda code: chain[code])
    assert [one.first.key.code for one in groups] == ["a"]
    assert len(groups[0].follows) == 3


@given(
    st.lists(
        st.tuples(st.sampled_from(sorted(catalogue())), st.floats(0, 60), st.sampled_from(["weeder-01", "weeder-02"])),
        max_size=40,
    ),
    st.dictionaries(st.sampled_from(sorted(catalogue())), st.frozensets(st.sampled_from(sorted(catalogue())))),
)
@pytest.mark.slow
def test_every_alarm_stands_in_exactly_one_group_whatever_the_catalogue_says(
    story: list[tuple[str, float, str]], odd: dict[str, frozenset[str]]
) -> None:
    alarms = [raised(*one) for one in story]
    for rules in (follows_from, lambda code: odd.get(code, frozenset())):
        groups = first_outs(alarms, rules)
        listed = [one.key for group in groups for one in (group.first, *group.follows)]
        assert sorted(map(str, listed)) == sorted(str(one.key) for one in alarms)
        assert all(one.key.source == group.first.key.source for group in groups for one in group.follows)
