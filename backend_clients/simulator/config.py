"""What a simulator process is told when it starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from backend_clients.edge.messages_down import Mission
from backend_clients.edge.topics import check_id
from backend_clients.simulator.cameras.map_feature import MapFeature
from backend_clients.simulator.families import FAMILIES, lean
from backend_clients.simulator.late_sensors import StationsMaker
from backend_clients.simulator.profile import Family, Profile

DEFAULT_LAT_DEG, DEFAULT_LON_DEG = 40.312546, -3.480860  # published position of the experimental site
LINK_LOST_S = (5.0, 300.0)  # what may be chosen, as with common autopilots


@dataclass(frozen=True, slots=True)
class RobotConfig:
    """One simulated robot.

    Args:
        id: robot id, also its topic and its path below the simulator's HTTP address.
        name: what people call it.
        token: bearer token of its HTTP endpoint.
        datum_lat_deg, datum_lon_deg: WGS84 origin of its ENU frame.
        x_m, y_m, theta_rad: where it stands at first start, which is its home too.
        soc: battery charge at first start, 0 to 1.
        family: what machine it is.
        is_lean: cheap enough for a thousand: it runs on rails, steps and reports at 2 Hz.
        link_lost_pause_s: without the console for so long, an unattended mission pauses.
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
    family: Family = "weeder"
    is_lean: bool = False
    link_lost_pause_s: float = 10.0

    def __post_init__(self) -> None:
        check_id(self.id)
        low_s, high_s = LINK_LOST_S
        if not low_s <= self.link_lost_pause_s <= high_s:
            raise ValueError(f"robot {self.id}: link_lost_pause_s is outside {low_s:g} to {high_s:g}")
        if not self.token:
            raise ValueError(f"robot {self.id}: the HTTP token is empty")
        if self.family not in FAMILIES:
            raise ValueError(f"robot {self.id}: there is no family {self.family!r}; use {', '.join(FAMILIES)}")

    @property
    def profile(self) -> Profile:
        """What its family can do."""
        return lean(self.family) if self.is_lean else FAMILIES[self.family]


@dataclass(frozen=True, slots=True)
class Job:
    """A mission a robot is busy with when the simulation begins.

    Args:
        done: share of its path that is behind it.
        is_endless: it begins again as soon as it is done.
    """

    mission: Mission
    done: float = 0.0
    is_endless: bool = False


@dataclass(frozen=True, slots=True)
class CloudConfig:
    """Where the robots' cloud agents take missions.

    Args:
        url: of the context broker.
        farm: as in the names of the farm's entities.
    """

    url: str
    tenant: str = ""
    path: str = "/"
    farm: str = "farm"


@dataclass(frozen=True, slots=True)
class SimulatorConfig:
    """One simulator process with its robots.

    Args:
        broker_url: ``mqtt://host:port``.
        robots: the robots to run.
        host, port: where robot HTTP listens; port 0 takes a free one.
        seed: makes the world's noise repeatable; boot ids and challenges never repeat.
        speed: missions run this many times faster than real time; driving by hand never does.
        state_dir: where latch, mission and progress survive a restart; ``None`` keeps nothing.
        jobs: missions that robots are busy with when the simulation begins.
        features: the farm's map, which cameras show.
        is_always_day: cameras see a summer morning at any hour, instead of the light of the wall clock.
        cloud: context broker of the robots' cloud agents, ``None`` if they have none.
        opening: situations that happen first, by robot; with it, more come and go on robots that have a job.
        stations: makes the field sensors beside the robots, called some seconds after the start; ``None`` has none.
        are_cameras_ready: the drawing of pictures is started a little after the robots instead of with the first one.
        sensor_speed: their weather goes this many times faster than real time.
    """

    broker_url: str
    robots: tuple[RobotConfig, ...]
    host: str = "127.0.0.1"
    port: int = 0
    seed: int = 1
    speed: float = 1.0
    state_dir: Path | None = None
    jobs: Mapping[str, Job] = field(default_factory=dict)
    opening: Mapping[str, str] | None = None
    features: tuple[MapFeature, ...] = ()
    is_always_day: bool = False
    cloud: CloudConfig | None = None
    stations: StationsMaker | None = None
    are_cameras_ready: bool = False
    sensor_speed: float = 1.0

    def __post_init__(self) -> None:
        ids = [robot.id for robot in self.robots]
        if len(set(ids)) != len(ids):
            raise ValueError(f"two simulated robots have the same id: {', '.join(sorted(ids))}")
        if not 0.1 <= self.speed <= 200:
            raise ValueError(f"speed {self.speed:g} is outside 0.1 to 200")
