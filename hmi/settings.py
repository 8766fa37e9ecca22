"""Settings from ``headland.toml`` and ``HEADLAND_*`` variables; variables win.

Every field is documented here and printed by ``headland check``. Outside demo mode the default secret is refused.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Literal
from urllib.parse import urlsplit
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import Field, field_validator, model_validator
from pydantic_settings import (
    BaseSettings,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
    TomlConfigSettingsSource,
)

DEFAULT_SECRET = "change-me"  # noqa: S105 - the value that is refused
Port = Annotated[int, Field(ge=0, le=65535)]


_HOST = re.compile(r"[A-Za-z0-9.-]+|\[[0-9A-Fa-f:.]+\]")


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

    @field_validator("online_tiles_url")
    @classmethod
    def _tile_url(cls, value: str | None) -> str | None:
        return None if not value else checked_template(value)

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
