"""The media process listens to robots while somebody looks, and no longer."""

from __future__ import annotations

from pathlib import Path

from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Up
from hmi.clock import FakeClock
from hmi.media.ear import GRACE_S, Ear
from hmi.media.intake import SUBSCRIPTIONS, Intake
from hmi.media.studio import Studio
from hmi.twin.farm import Farm, FarmRobot
from tests.hmi.media.studio_stage import ROBOT, SECRET, Planter

WANTED = [("edge/+/telemetry", 0), ("edge/+/factsheet", 1)]


class Broker:
    """Remembers what is subscribed now."""

    def __init__(self) -> None:
        self.filters: dict[str, int] = {}

    def subscribe(self, topic_filter: str, qos: int) -> None:
        """See ``MqttLink``."""
        self.filters[topic_filter] = qos

    def unsubscribe(self, topic_filter: str) -> None:
        """See ``MqttLink``."""
        del self.filters[topic_filter]


def test_nothing_is_subscribed_before_somebody_looks() -> None:
    broker = Broker()
    ear = Ear(broker, WANTED)
    assert not ear.rest(1000.0)
    assert broker.filters == {}
    ear.look(1000.0)
    assert broker.filters == dict(WANTED)


def test_a_page_that_is_loaded_again_finds_everything_still_there() -> None:
    broker = Broker()
    ear = Ear(broker, WANTED)
    ear.look(0.0)
    assert not ear.rest(GRACE_S - 0.1)
    ear.look(GRACE_S)
    assert not ear.rest(2 * GRACE_S - 0.1)
    assert broker.filters == dict(WANTED)


def test_when_the_last_one_left_nothing_is_subscribed_and_it_is_said_once() -> None:
    broker = Broker()
    ear = Ear(broker, WANTED)
    ear.look(0.0)
    assert ear.rest(GRACE_S)
    assert broker.filters == {}
    assert not ear.rest(GRACE_S + 1)
    ear.look(GRACE_S + 2)
    assert broker.filters == dict(WANTED)


def test_a_pose_from_before_is_never_shown_to_the_next_who_looks(tmp_path: Path) -> None:
    clock, broker = FakeClock(), Broker()
    intake = Intake(clock)
    studio = Studio(intake, tmp_path, SECRET, clock, Ear(broker, SUBSCRIPTIONS))
    try:
        studio.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 0.0)]))
        box = studio.enter("a" * 32, ROBOT, may_replay=False)
        assert set(broker.filters) == {name for name, _ in SUBSCRIPTIONS}
        planter = Planter(intake)
        planter.introduce()
        planter.stand(3.0)
        studio.tick()
        assert studio.world.robots() == [ROBOT]
        studio.leave("a" * 32, box)
        clock.advance(GRACE_S + 1)
        studio.attend()
        assert broker.filters == {}
        assert studio.world.robots() == []
        assert intake.newest(ROBOT, Up.TELEMETRY, up.Telemetry) is None
    finally:
        studio.server.stop()
