"""Who is asking: the facts about one signed-in browser."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime

from hmi.domain.role import Role


@dataclass(frozen=True, slots=True)
class SessionInfo:
    """One signed-in browser.

    ``session_id`` is the SHA-256 of the cookie: it names the session, for example as lease owner, and opens nothing.
    ``device_id`` is an enrolled device, or a ``browser-...`` id that lasts as long as the session; ``device_name`` is
    empty for the latter. ``csrf`` must come back in ``X-Headland-CSRF`` with everything but reading.
    ``is_wall``: a wall screen, which watches and does not time out.
    """

    session_id: str
    user_id: str
    user_name: str
    role: Role
    device_id: str
    device_name: str
    farm_id: str
    csrf: str = field(repr=False)
    expires_utc: datetime
    is_wall: bool = False
