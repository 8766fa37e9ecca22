"""Settings from ``headland.toml`` and ``HEADLAND_*`` variables; variables win.

Every field is documented here and printed by ``headland check``. Outside demo mode the default secret is refused.
"""

from __future__ import annotations

import re
from ipaddress import ip_network
from pathlib import Path
from typing import Annotated, Literal
from urllib.parse import urlsplit
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import Field, SecretStr, ValidationInfo, field_validator, model_validator
from pydantic_settings import (
    BaseSettings,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
    TomlConfigSettingsSource,
)

DEFAULT_SECRET = "change-me"  # noqa: S105 - the value that is refused
ANYWHERE = ("0.0.0.0", "::")  # noqa: S104 - compared with, not bound to
Port = Annotated[int, Field(ge=0, le=65535)]


_HOST = re.compile(r"[A-Za-z0-9.-]+|\[[0-9A-Fa-f:.]+\]")


def port_range(value: str) -> range | None:
    """Return the ports of ``40000-40063``, ``None`` if nothing is said; raises ``ValueError``."""
    if not value:
        return None
    first, dash, last = value.partition("-")
    if not (dash and first.isdecimal() and last.isdecimal() and 1024 <= int(first) <= int(last) <= 65535):
        raise ValueError("camera_udp_ports must be two ports from 1024 to 65535 such as 40000-40063")
    return range(int(first), int(last) + 1)


def checked_template(value: str) -> str:
    """Return the address of online tiles if it names one server and each tile; raises ``ValueError``."""
    parts = urlsplit(value)
    host = re.sub(r":\d+\Z", "", parts.netloc)
    if parts.scheme not in ("http", "https") or not _HOST.fullmatch(host):
        raise ValueError("online_tiles_url must be http(s)://host/..., one host without name, password or {s}")
    if not all(parts.path.count(f"{{{key}}}") + parts.query.count(f"{{{key}}}") == 1 for key in "zxy"):
        raise ValueError("online_tiles_url must hold {z}, {x} and {y} once each")
    if re.search(r"[{}\s\"'<>\\;,]", re.sub(r"\{[zxy]\}", "", value)):
        raise ValueError("online_tiles_url may hold {z}, {x}, {y} and nothing else in braces, and no spaces or quotes")
    return value


def origin_of(template: str) -> str:
    """Return scheme, host and port of the online tiles, as the content security policy names them."""
    parts = urlsplit(template)
    return f"{parts.scheme}://{parts.netloc}"


def _no_secret() -> SecretStr:
    return SecretStr("")


class Settings(BaseSettings):
    """Everything an installation can choose; one instance per process."""

    model_config = SettingsConfigDict(env_prefix="HEADLAND_", toml_file="headland.toml", extra="forbid", frozen=True)

    host: str = Field(
        "127.0.0.1",
        description="Address the console and the STOP gateway listen on. "
        "0.0.0.0 lets every device in the network reach them: use it on trusted networks only.",
    )
    port: Port = Field(8080, description="Port of the console.")
    data: Path = Field(Path("data"), description="Folder for the database, keys, logs and uploads.")
    demo: bool = Field(False, description="Simulated robots and demo accounts. Set by `headland demo` only.")
    demo_fleet: Literal["full", "small"] = Field(
        "full", description="Robots of the demo: full is a farm of 24 at work, small three weeders that wait for you."
    )
    media: bool = Field(
        True,
        description="Run the media process, which draws the 3D twin. Off, the twin's screen shows the map instead.",
    )
    cameras: bool = Field(
        True, description="Run the camera process. Off, no screen shows pictures; nothing else changes."
    )
    camera_viewers: int = Field(
        64, ge=1, le=500, description="Most WebRTC streams at once. Further viewers get JPEG pictures."
    )
    camera_workers: int = Field(
        32, ge=1, le=200, description="Most cameras pulled at once; each takes 30 to 70 MB while somebody looks."
    )
    camera_udp_ports: str = Field(
        "",
        description="UDP ports of WebRTC streams on this machine, e.g. 40000-40063, for a firewall between tablets and "
        "console; each stream takes one. Empty takes any free port.",
    )
    camera_video_width: int = Field(
        1280,
        ge=160,
        le=4096,
        description="Wider pictures are made smaller for WebRTC, px. Full size is always there as JPEG.",
    )
    secret: str = Field(
        DEFAULT_SECRET,
        min_length=8,
        description="Signs STOP tokens. At least 32 random "
        "characters; `headland check` makes one. Demo mode makes its own.",
    )
    broker_url: str = Field(
        "mqtt://127.0.0.1:1883",
        description="MQTT broker of the robots, mqtt://host:port or mqtts://user:password@host:port.",
    )
    broker_ca: Path | None = Field(None, description="CA file for an mqtts broker with its own certificate.")
    stop_port: Port = Field(8081, description="Port of the STOP gateway; 0 takes a free one.")
    stop_public_url: str | None = Field(
        None,
        description="Address of the STOP gateway as browsers see it, e.g. "
        "https://farm.example/stop behind a reverse proxy. "
        "Default: the console's host name with stop_port.",
    )
    tls_cert: Path | None = Field(None, description="Certificate (PEM) of console and gateway; see `headland cert`.")
    tls_key: Path | None = Field(None, description="Key (PEM) of that certificate.")
    database_url: str | None = Field(None, description="SQLAlchemy URL; default is SQLite in the data folder.")
    farm_id: str = Field("farm", description="Id of the farm this console serves.")
    farm_name: str = Field("My farm", description="Name of the farm, shown in the top bar.")
    time_zone: str = Field(
        "",
        description="Time zone of the farm, e.g. Europe/Amsterdam, for the queue's times and blackout windows. "
        "Default: that of this machine.",
    )
    session_hours: float = Field(12, gt=0, le=168, description="A signed-in browser stays signed in this long.")
    checklist_required: bool = Field(
        True, description="A supervised mission starts only after the person has ticked the robot's pre-start list."
    )
    checklist_hours: float = Field(
        12, gt=0, le=168, description="A ticked pre-start list counts this long, for the person who ticked it."
    )
    allowed_origins: list[str] = Field(
        default_factory=list,
        description="Further origins whose pages may talk "
        "to the console, e.g. https://farm.example. Its own is always allowed.",
    )

    notify_private: bool = Field(
        False,
        description="Whether alarm notifications may go to this machine and to private networks, e.g. a mail server "
        "of the farm. Off: public addresses only. Link-local and cloud metadata addresses are never allowed.",
    )
    notify_hosts: list[str] = Field(
        default_factory=list,
        description="If any are named, alarm notifications go to these hosts only: hooks.example, or .farm.example.",
    )
    shift_ends: list[str] = Field(
        default_factory=lambda: ["06:00", "14:00", "22:00"],
        description="Times of day when shifts end, on the farm's clock; an alarm can be shelved until then.",
    )

    map_engine: Literal["auto", "full", "simple"] = Field(
        "auto",
        description="How maps are drawn: full by WebGL, simple without it. auto draws the map of one robot by WebGL "
        "only where a graphics chip does it, and the map of the fleet wherever there is WebGL.",
    )
    cloud_url: str | None = Field(
        None,
        description="Context broker (NGSI-v2) of the cloud, e.g. https://broker.example/orion. Off if not set.",
    )
    cloud_tenant: str = Field("", description="Tenant there (Fiware-Service): a-z, 0-9, _; empty is the default one.")
    cloud_path: str = Field("/", description="Service path there, e.g. /farm/north.")
    cloud_ca: Path | None = Field(None, description="CA file for a context broker with its own certificate.")
    cloud_token: SecretStr = Field(
        default_factory=_no_secret, description="Fixed credentials, the whole value of the header, e.g. Bearer ..."
    )
    cloud_token_header: str = Field(
        "Authorization", description="Header of the credentials, e.g. X-Auth-Token; for OAuth2 too."
    )
    cloud_oauth_url: str | None = Field(None, description="OAuth2 token endpoint, instead of fixed credentials.")
    cloud_oauth_client: str = Field("", description="OAuth2 client id.")
    cloud_oauth_secret: SecretStr = Field(default_factory=_no_secret, description="OAuth2 client secret.")
    cloud_oauth_user: str = Field("", description="OAuth2 user; with one the grant is password.")
    cloud_oauth_password: SecretStr = Field(default_factory=_no_secret, description="OAuth2 password of that user.")
    cloud_notify_url: str | None = Field(
        None,
        description="Address of this console as the context broker reaches it, e.g. https://farm.example, so that it "
        "tells of changes at once. Without it the map in the cloud is read every five minutes.",
    )
    cloud_notify_from: list[str] = Field(
        default_factory=list, description="Addresses or networks the context broker posts from; none means any."
    )
    cloud_period_s: float = Field(
        1.0, ge=0.1, le=60, description="How often robots that moved are told to the cloud, seconds."
    )
    cloud_outbox_mb: int = Field(
        64, ge=1, le=10_000, description="Room on disk for what waits while the cloud is away, MB; the oldest goes."
    )
    cloud_outbox_days: float = Field(7, gt=0, le=365, description="What waited so long is dropped.")
    demo_cloud: bool = Field(
        True, description="Run a simulated context broker in the demo, and a weather forecast with it."
    )
    planner_url: str | None = Field(
        None,
        description="Planner service (docs/protocols/planner.md), e.g. https://plans.example/v1. Missions are planned "
        "there, checked here, and planned here if it does not answer. Not set: always here.",
    )
    planner_token: SecretStr = Field(default_factory=_no_secret, description="Bearer token of the planner service.")
    planner_ca: Path | None = Field(None, description="CA file for a planner service with its own certificate.")
    planner_timeout_s: float = Field(
        30, ge=1, le=600, description="A plan of the planner service may take this long; then it is made here, seconds."
    )
    demo_planner: bool = Field(
        False,
        description="Run a planner service in the demo. Off: planning twice loads the geometry in two processes.",
    )
    forecast_url: str | None = Field(
        None, description="Weather forecast (docs/protocols/forecast.md), e.g. https://weather.example/v1."
    )
    forecast_token: SecretStr = Field(default_factory=_no_secret, description="Bearer token of the weather forecast.")
    forecast_ca: Path | None = Field(None, description="CA file for a weather forecast with its own certificate.")
    demo_light: Literal["day", "clock"] = Field(
        "day",
        description="What the demo's cameras see: day is a summer morning at any hour, clock the light of now.",
    )

    base_map_mb: int = Field(
        4096, ge=1, description="Room for the base maps of a farm in the data folder, MB. What is over it is refused."
    )
    base_map_upload_mb: int = Field(2048, ge=1, description="Largest aerial photo or tile archive to upload, MB.")
    online_tiles_url: str | None = Field(
        None,
        description="Online map for everybody, e.g. https://tiles.example/{z}/{x}/{y}.png. Off by default: with it, "
        "each browser that chooses it asks that server, which sees the tablet's address and what is looked at.",
    )
    online_tiles_credit: str = Field("", max_length=160, description="Who must be named beside the online map.")
    online_tiles_max_zoom: int = Field(19, ge=1, le=24, description="Nearest zoom the online map has.")

    camera_networks: list[str] = Field(
        default_factory=list,
        description="Networks where cameras may be, e.g. 192.168.7.0/24. A robot's own host is always allowed; this "
        "machine only if a network such as 127.0.0.0/8 names it; link-local and cloud metadata addresses never.",
    )
    record_cameras: Literal["auto", "driving", "watched", "off"] = Field(
        "auto",
        description="Which cameras keep their last minute for clips: watched, those somebody looks at, and one of a "
        "robot while it has a STOP or an urgent alarm; driving, also the first camera of each robot that drives or "
        "works; off, none. auto is watched in the demo, else driving.",
    )
    record_most: int = Field(
        0,
        ge=0,
        le=64,
        description="At most so many cameras are held open for clips; each takes 1.5 % of a core and 40 MB. "
        "0 is 16, in the demo 4.",
    )
    mission_pictures: Literal["rows", "minutes", "off"] = Field(
        "rows",
        description="A picture of each mission at the end of a row, every mission_picture_minutes, or none. With "
        "record_cameras watched only from cameras that are open anyway.",
    )
    mission_picture_minutes: float = Field(5, ge=0.5, le=1440, description="Minutes between two pictures of a mission.")
    pictures_gb: float = Field(
        5, ge=0.1, description="Room for kept pictures and clips in the data folder, GB. The oldest go first."
    )
    pictures_days: int = Field(
        30, ge=1, le=36_500, description="Pictures and clips that nobody marked are kept this many days."
    )
    pictures_free_gb: float = Field(
        2, ge=0, description="With less room than this left on the disk, GB, no picture or clip is kept."
    )
    picture_watermark: bool = Field(
        False,
        description="Burn the person's name and the time into single pictures that are sent out, and show them over "
        "live ones. Clips are not changed.",
    )

    @field_validator("camera_udp_ports")
    @classmethod
    def _udp_ports(cls, value: str) -> str:
        port_range(value)
        return value

    @field_validator("camera_networks", "cloud_notify_from")
    @classmethod
    def _networks(cls, value: list[str], info: ValidationInfo) -> list[str]:
        try:
            return [str(ip_network(one, strict=False)) for one in value]
        except ValueError as error:
            raise ValueError(f"{info.field_name} must be networks such as 192.168.7.0/24: {error}") from error

    @field_validator("online_tiles_url")
    @classmethod
    def _tile_url(cls, value: str | None) -> str | None:
        return None if not value else checked_template(value)

    @field_validator("cloud_url", "cloud_oauth_url", "cloud_notify_url", "planner_url", "forecast_url")
    @classmethod
    def _cloud_address(cls, value: str | None) -> str | None:
        if not value:
            return None
        parts = urlsplit(value)
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.query or "@" in parts.netloc:
            raise ValueError("an address of a service must be http(s)://host/..., without name and password in it")
        return value.rstrip("/")

    @field_validator("cloud_tenant")
    @classmethod
    def _cloud_service(cls, value: str) -> str:
        if not re.fullmatch(r"[a-z0-9_]{0,50}", value):
            raise ValueError("cloud_tenant may hold a-z, 0-9 and _, at most 50")
        return value

    @field_validator("cloud_path")
    @classmethod
    def _cloud_service_path(cls, value: str) -> str:
        if not re.fullmatch(r"/|(/[A-Za-z0-9_]{1,50}){1,10}", value):
            raise ValueError("cloud_path must be / or /level/level with letters, digits and _, at most ten levels")
        return value

    @field_validator("stop_public_url")
    @classmethod
    def _http_url(cls, value: str | None) -> str | None:
        if value is not None and not value.startswith(("http://", "https://")):
            raise ValueError("stop_public_url must start with http:// or https://")
        return value.rstrip("/") if value else None

    @field_validator("shift_ends")
    @classmethod
    def _times(cls, value: list[str]) -> list[str]:
        if not all(re.fullmatch(r"([01]\d|2[0-3]):[0-5]\d", one) for one in value):
            raise ValueError("shift_ends must be times such as 06:00")
        return sorted(value)

    @field_validator("time_zone")
    @classmethod
    def _known_zone(cls, value: str) -> str:
        try:
            return ZoneInfo(value).key if value else ""
        except (ZoneInfoNotFoundError, ValueError, OSError) as error:
            raise ValueError(f"there is no time zone {value!r}; use a name such as Europe/Amsterdam") from error

    @model_validator(mode="after")
    def _whole(self) -> Settings:
        if bool(self.tls_cert) != bool(self.tls_key):
            raise ValueError("tls_cert and tls_key go together; `headland cert` makes both")
        if not self.demo and self.secret == DEFAULT_SECRET:
            raise ValueError(
                "the secret is the default one: set HEADLAND_SECRET or `secret` in headland.toml "
                "(`headland check` prints a fresh one)"
            )
        return self

    @property
    def is_tls(self) -> bool:
        """Whether console and gateway speak HTTPS."""
        return self.tls_cert is not None

    @property
    def near_host(self) -> str:
        """An address of this machine under which its own parts are reached from here."""
        return "127.0.0.1" if self.host in ANYWHERE else self.host

    @property
    def database(self) -> str:
        """The SQLAlchemy URL in force."""
        return self.database_url or f"sqlite:///{self.data / 'headland.db'}"

    @classmethod
    def settings_customise_sources(
        cls,
        settings_cls: type[BaseSettings],
        init_settings: PydanticBaseSettingsSource,
        env_settings: PydanticBaseSettingsSource,
        dotenv_settings: PydanticBaseSettingsSource,
        file_secret_settings: PydanticBaseSettingsSource,
    ) -> tuple[PydanticBaseSettingsSource, ...]:
        """Arguments, then variables, then the file."""
        return init_settings, env_settings, TomlConfigSettingsSource(settings_cls)
