"""What the screens need from the console; filled once by the composition root."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from starlette.requests import HTTPConnection

from hmi.domain.robot import Robot
from hmi.domain.role import Permission, Role
from hmi.settings import Settings

if TYPE_CHECKING:
    from hmi.clock import Clock


class Visitor(Protocol):
    """The signed-in person and browser a page is made for."""

    @property
    def session_id(self) -> str:
        """Names this browser in leases; no secret."""
        ...

    @property
    def farm_id(self) -> str:
        """The farm the person works for."""
        ...

    @property
    def user_id(self) -> str:
        """Id of the person, also their sign-in name."""
        ...

    @property
    def user_name(self) -> str:
        """Name as shown to others."""
        ...

    @property
    def role(self) -> Role:
        """What the person is trusted with."""
        ...

    @property
    def device_name(self) -> str:
        """Name of the enrolled tablet, empty for any other browser."""
        ...

    @property
    def csrf(self) -> str:
        """Token for REST calls of this browser."""
        ...


class FleetView(Protocol):
    """The newest known state of every robot."""

    def robot(self, robot_id: str) -> Robot | None:
        """Return all that is known of one robot, ``None`` if it was never heard of."""
        ...

    def robots(self) -> Iterable[Robot]:
        """Return every robot known now, registered or not."""
        ...


class Authorise(Protocol):
    """The one question about rights."""

    def __call__(self, actor: Any, permission: Permission, robot: Any = None, /) -> bool:
        """Say whether this person may do this, to this robot."""
        ...


@dataclass(frozen=True, slots=True)
class StopAddress:
    """Where browsers find the STOP gateway: the public address, else the console's host with ``port``."""

    port: int
    public_url: str | None = None


@dataclass(frozen=True, slots=True)
class PageServices:
    """Everything a page may use. Pages read state here; whatever changes something goes through REST.

    ``visitor`` answers who is signed in, from the session cookie of a request; ``None`` shows the sign-in page.
    ``features`` and ``missions`` are the services of the missions screen.
    """

    settings: Settings
    clock: Clock
    fleet: FleetView
    visitor: Callable[[HTTPConnection], Visitor | None]
    authorise: Authorise
    stop: StopAddress
    features: Any = None
    missions: Any = None
