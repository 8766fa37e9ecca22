"""Settings from ``headland.toml`` and ``HEADLAND_*`` variables; variables win.

Every field is documented here and printed by ``headland check``. Outside demo mode the default secret is refused.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated
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
    allowed_origins: list[str] = Field(
        default_factory=list,
        description="Further origins whose pages may talk "
        "to the console, e.g. https://farm.example. Its own is always allowed.",
    )

    @field_validator("stop_public_url")
    @classmethod
    def _http_url(cls, value: str | None) -> str | None:
        if value is not None and not value.startswith(("http://", "https://")):
            raise ValueError("stop_public_url must start with http:// or https://")
        return value.rstrip("/") if value else None

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
