"""Operator heartbeats: forwarded because a browser said so, at most once a second, never made up."""

from __future__ import annotations

from hmi.commands.lease_service import LeaseOp
from hmi.domain.command import OperatorPulse
from tests.hmi.commands.field import JONAS, MARTHA, Field


def holding() -> Field:
    """Return a field whose weeder Martha controls."""
    field = Field()
    field.desk.leases.operate(MARTHA, "weeder-01", LeaseOp.REQUEST, tick_id=field.tick())
    return field


def pulses(field: Field) -> list[OperatorPulse]:
    """Return the heartbeats the robot got."""
    return [o for o in field.weeder.orders if isinstance(o, OperatorPulse)]


def test_a_sign_of_life_reaches_the_robot_and_renews_control() -> None:
    field = holding()
    for _ in range(30):
        field.wait(1.0)
        assert field.desk.pulse.here(MARTHA, "weeder-01", field.tick())
    assert field.desk.leases.of("weeder-01") is not None
    sent = pulses(field)
    assert len(sent) == 30
    assert [p.lease_seq for p in sent] == list(range(1, 31))
    assert sent[-1].challenge == field.weeder.challenge


def test_without_a_browser_nothing_is_sent() -> None:
    field = holding()
    field.wait(9)
    assert pulses(field) == []


def test_two_pages_of_the_holder_make_one_heartbeat_a_second() -> None:
    field = holding()
    for _ in range(40):
        field.wait(0.25)
        field.desk.pulse.here(MARTHA, "weeder-01", field.tick())
    assert len(pulses(field)) <= 11


def test_a_timer_that_wanders_loses_no_heartbeat() -> None:
    field = holding()
    for number in range(20):
        field.wait(0.98 if number % 2 else 1.02)
        field.desk.pulse.here(MARTHA, "weeder-01", field.tick())
    assert len(pulses(field)) == 20


def test_a_sign_of_life_that_was_held_up_proves_nothing() -> None:
    field = holding()
    held_up = [field.tick() for _ in range(5)]
    field.wait(5)
    assert not any(field.desk.pulse.here(MARTHA, "weeder-01", tick) for tick in held_up)
    field.wait(5)
    assert pulses(field) == []
    assert field.desk.leases.of("weeder-01") is None


def test_somebody_elses_page_keeps_nobody_in_control() -> None:
    field = holding()
    assert not field.desk.pulse.here(JONAS, "weeder-01", field.tick())
    assert not field.desk.pulse.here(MARTHA, "weeder-99", field.tick())
    assert pulses(field) == []
