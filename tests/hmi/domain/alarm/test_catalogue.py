"""The catalogue says for every alarm what a person needs."""

from __future__ import annotations

from pathlib import Path

from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.priority import Priority
from hmi.presenters.alarm_catalogue import markdown
from hmi.presenters.diagnosis import CHECKS, diagnose
from hmi.presenters.scene import Scene

PAGE = Path(__file__).parents[4] / "docs/alarm_catalogue.md"


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


def test_the_page_of_alarm_types_is_up_to_date() -> None:
    assert PAGE.read_text("utf-8") == markdown(), "run `make alarm-catalogue`"


def test_every_guided_check_is_known_and_never_fails_for_want_of_values() -> None:
    for one in catalogue().values():
        assert set(one.diagnosis) <= CHECKS.keys(), one.code
        if one.diagnosis:
            found = diagnose(one.diagnosis, Scene(0.0, None))
            assert len(found["steps"]) == len(one.diagnosis)
            assert found["conclusion"].endswith(".")


def test_whatever_is_suppressed_by_design_is_suppressed_by_the_console() -> None:
    causes = {cause for one in catalogue().values() for cause in one.suppressed_by}
    assert causes == {"broker-lost", "all-silent"}
