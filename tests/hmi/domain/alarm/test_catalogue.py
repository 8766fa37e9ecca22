"""The catalogue says for every alarm what a person needs."""

from __future__ import annotations

from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.priority import Priority


def test_every_type_says_cause_consequence_steps_and_who() -> None:
    for code, one in catalogue().items():
        assert one.steps, code
        assert all(text and text[0].isupper() for text in (one.title, one.cause, one.consequence, *one.steps)), code
        assert all(text.endswith(".") for text in (one.cause, one.consequence)), code
        assert one.who in ("operator", "admin", "planner", "anybody at the machine"), code
        assert len(one.title) <= 48, code


def test_what_a_robot_of_the_edge_contract_reports_has_words() -> None:
    reported = ("hardware-stop", "person-ahead", "tool-interlock", "rtk-float", "battery-low", "battery-very-low",
                "battery-empty")  # fmt: skip
    assert set(reported) <= catalogue().keys()


def test_critical_is_only_what_may_hurt_somebody_or_blinds_everybody() -> None:
    critical = {code for code, one in catalogue().items() if one.priority is Priority.CRITICAL}
    assert critical == {
        "stop-not-confirmed",
        "moves-after-stop",
        "tool-on-unasked",
        "outside-fence",
        "gateway-down",
        "broker-lost",
        "all-silent",
    }
