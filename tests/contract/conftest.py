"""A broker of each kind, and a fresh simulated weeder on it for each test."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.brokers import MOSQUITTO, start_amqtt, start_mosquitto
from tests.contract.wire import Listener, Site, running_simulator


@pytest.fixture(scope="session", params=["mosquitto", "amqtt"])
def broker(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Return the address of a real broker; every contract test runs on both kinds."""
    if request.param == "amqtt":
        with start_amqtt() as url:
            yield url
        return
    if MOSQUITTO is None:
        pytest.skip("mosquitto is not installed (apt-get install mosquitto)")
    with start_mosquitto(tmp_path_factory.mktemp("mosquitto")) as url:
        yield url


@pytest.fixture
def site(broker: str) -> Iterator[Site]:
    """Return a running simulator with one weeder."""
    with running_simulator(broker, datum_lat_deg=52.0, datum_lon_deg=5.0, y_m=-2.0, theta_rad=1.5708) as site:
        yield site


@pytest.fixture
def listener(broker: str, site: Site) -> Iterator[Listener]:
    """Return a listener that has heard the robot."""
    with Listener(broker) as listener:
        from backend_clients.edge import messages_up as up

        listener.wait(up.Heartbeat)
        yield listener
