"""What a simulator process is told when it starts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from backend_clients.edge.topics import check_id

DEFAULT_LAT_DEG, DEFAULT_LON_DEG = 40.312546, -3.480860  # published position of the experimental site


@dataclass(frozen=True, slots=True)
class WeederConfig:
    """One simulated weeder.

    Args:
        id: robot id, also its topic and its path below the simulator's HTTP address.
        name: what people call it.
        token: bearer token of its HTTP endpoint.
        datum_lat_deg, datum_lon_deg: WGS84 origin of its ENU frame.
        x_m, y_m, theta_rad: where it stands at first start, which is its home too.
        soc: battery charge at first start, 0 to 1.
    """

    id: str
    name: str
    token: str
    datum_lat_deg: float = DEFAULT_LAT_DEG
    datum_lon_deg: float = DEFAULT_LON_DEG
    x_m: float = 0.0
    y_m: float = 0.0
    theta_rad: float = 0.0
    soc: float = 0.92

    def __post_init__(self) -> None:
        check_id(self.id)
        if not self.token:
            raise ValueError(f"weeder {self.id}: the HTTP token is empty")


@dataclass(frozen=True, slots=True)
class SimulatorConfig:
    """One simulator process with its robots.

    Args:
        broker_url: ``mqtt://host:port``.
        weeders: the robots to run.
        host, port: where robot HTTP listens; port 0 takes a free one.
        seed: makes the world's noise repeatable; boot ids and challenges never repeat.
        speed: missions run this many times faster than real time; driving by hand never does.
        state_dir: where latch, mission and progress survive a restart; ``None`` keeps nothing.
    """

    broker_url: str
    weeders: tuple[WeederConfig, ...]
    host: str = "127.0.0.1"
    port: int = 0
    seed: int = 1
    speed: float = 1.0
    state_dir: Path | None = None

    def __post_init__(self) -> None:
        ids = [weeder.id for weeder in self.weeders]
        if len(set(ids)) != len(ids):
            raise ValueError(f"two simulated robots have the same id: {', '.join(sorted(ids))}")
        if not 0.1 <= self.speed <= 200:
            raise ValueError(f"speed {self.speed:g} is outside 0.1 to 200")
