"""What the media process keeps of what robots say."""

from __future__ import annotations

from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import encode
from backend_clients.edge.topics import Up, topic
from hmi.clock import FakeClock
from hmi.media.intake import MOST_STRANGERS, Intake


def telemetry(robot: str, mono_ms: int, x_m: float) -> bytes:
    """Return a telemetry message."""
    return encode(
        up.Telemetry(
            robot=robot, boot="boot-0001", seq=mono_ms, mono_ms=mono_ms, wall_ms=0,
            lat_deg=52.0, lon_deg=5.0, x_m=x_m, y_m=0.0, theta_rad=0.0, speed_mps=1.0,
        )
    )  # fmt: skip


def test_the_newest_message_counts_and_its_age_is_that_of_its_source() -> None:
    clock = FakeClock()
    intake = Intake(clock)
    at = topic("weeder-07", Up.TELEMETRY)
    intake.take(at, telemetry("weeder-07", 1000, 1.0), False)
    first = intake.newest("weeder-07", Up.TELEMETRY, up.Telemetry)
    clock.advance(3.0)
    intake.take(at, telemetry("weeder-07", 2000, 2.0), False)  # two seconds late
    second = intake.newest("weeder-07", Up.TELEMETRY, up.Telemetry)
    assert first is not None
    assert second is not None
    assert second[0].x_m == 2.0
    assert clock.mono_s() - second[1] == 2.0


def test_broken_and_foreign_messages_are_nothing() -> None:
    intake = Intake(FakeClock())
    intake.take(topic("weeder-07", Up.TELEMETRY), b"{", False)
    intake.take(topic("weeder-08", Up.TELEMETRY), telemetry("weeder-07", 1, 1.0), False)
    assert intake.newest("weeder-07", Up.TELEMETRY, up.Telemetry) is None
    assert intake.newest("weeder-08", Up.TELEMETRY, up.Telemetry) is None
    assert intake.newest("weeder-09", Up.TELEMETRY, up.Telemetry) is None


def test_a_message_that_cannot_be_read_leaves_the_one_before_which_gets_old() -> None:
    clock = FakeClock()
    intake = Intake(clock)
    at = topic("weeder-07", Up.TELEMETRY)
    intake.take(at, telemetry("weeder-07", 1000, 1.0), False)
    assert intake.newest("weeder-07", Up.TELEMETRY, up.Telemetry) is not None
    read_s = clock.mono_s()
    for _ in range(3):
        clock.advance(1.0)
        intake.take(at, b'{"lat_deg": null}', False)
        intake.take(at, b"{", False)  # two between two looks
        kept = intake.newest("weeder-07", Up.TELEMETRY, up.Telemetry)
        assert kept is not None
        assert (kept[0].x_m, kept[1]) == (1.0, read_s)
    clock.advance(1.0)
    intake.take(at, telemetry("weeder-07", 5000, 2.0), False)
    newest = intake.newest("weeder-07", Up.TELEMETRY, up.Telemetry)
    assert newest is not None
    assert (newest[0].x_m, newest[1]) == (2.0, clock.mono_s())


def test_strangers_cannot_fill_the_memory() -> None:
    intake = Intake(FakeClock())
    for number in range(MOST_STRANGERS + 50):
        intake.take(topic(f"r{number}", Up.TELEMETRY), b"{}", False)
    assert len(intake.robots()) == MOST_STRANGERS


def test_the_farms_own_robots_always_come_in_however_many_there_are() -> None:
    intake = Intake(FakeClock())
    own = [f"own{number}" for number in range(MOST_STRANGERS + 100)]
    intake.take(topic("own0", Up.TELEMETRY), b"{}", False)
    for number in range(MOST_STRANGERS + 50):
        intake.take(topic(f"r{number}", Up.TELEMETRY), b"{}", False)
    intake.own(own)
    for robot in own:
        intake.take(topic(robot, Up.TELEMETRY), b"{}", False)
    assert set(own) <= set(intake.robots())
    assert len(intake.robots()) < len(own) + MOST_STRANGERS
    intake.forget(but=own)
    for number in range(MOST_STRANGERS + 50):
        intake.take(topic(f"s{number}", Up.TELEMETRY), b"{}", False)
    assert len(intake.robots()) == len(own) + MOST_STRANGERS
