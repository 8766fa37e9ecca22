"""Where alarms are told, and which of them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum
from urllib.parse import urlsplit

from hmi.domain.alarm.live_alarm import What
from hmi.domain.alarm.priority import Priority
from hmi.notifications.errors import BadChannel

TELLABLE = (What.RAISED, What.ESCALATED, What.RETURNED, What.ACKNOWLEDGED)
MAX_CHANNELS, MAX_RECIPIENTS = 20, 20
LEFT_OUT = "…"
_MAIL = re.compile(r"[^@\s,;<>\"]{1,64}@[^@\s,;<>\"]{1,190}")


class Kind(StrEnum):
    """How a channel tells."""

    WEBHOOK = "webhook"
    EMAIL = "email"


class Security(StrEnum):
    """How the connection to a mail server is kept secret."""

    TLS = "tls"
    STARTTLS = "starttls"
    NONE = "none"


@dataclass(frozen=True, slots=True)
class Webhook:
    """An address that takes a POST; with a secret the body is signed, see docs/alarms.md."""

    url: str

    @property
    def shown(self) -> str:
        """Return where it goes without path and query: whoever knows those may post there."""
        parts = urlsplit(self.url)
        return f"{parts.scheme}://{parts.netloc.rpartition('@')[2]}/{LEFT_OUT}"


@dataclass(frozen=True, slots=True)
class Mail:
    """A mail server and who gets the mail."""

    host: str
    port: int
    security: Security
    user: str
    sender: str
    recipients: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Channel:
    """One way to tell people.

    Args:
        priorities, steps: what it tells; robots: of which, all if none is named.
        per_hour: most messages an hour; what is more goes as one message that lists it.
        secret: signing key or password; empty for none. Never shown.
    """

    id: str
    name: str
    is_on: bool
    way: Webhook | Mail
    priorities: frozenset[Priority]
    steps: frozenset[What]
    robots: frozenset[str] = frozenset()
    per_hour: int = 30
    secret: str = ""

    @property
    def kind(self) -> Kind:
        """How it tells."""
        return Kind.WEBHOOK if isinstance(self.way, Webhook) else Kind.EMAIL

    def wants(self, what: What, priority: Priority, source: str) -> bool:
        """Say whether this step of this alarm is told."""
        if not self.is_on or what not in self.steps or priority not in self.priorities:
            return False
        return not self.robots or source in self.robots

    def check(self) -> None:
        """Return if it can be used; raises ``BadChannel``."""
        if not self.priorities or not self.steps:
            raise BadChannel("Choose at least one priority and one occasion.", "priorities")
        if unknown := self.steps - set(TELLABLE):
            raise BadChannel(f"{min(unknown)} is not told.", "steps")
        if isinstance(self.way, Mail):
            _check_mail(self.way)


def _check_mail(mail: Mail) -> None:
    if not mail.recipients or len(mail.recipients) > MAX_RECIPIENTS:
        raise BadChannel(f"Name one to {MAX_RECIPIENTS} recipients.", "recipients")
    for one in (mail.sender, *mail.recipients):
        if not _MAIL.fullmatch(one) or not one.isprintable():
            raise BadChannel(f"{one[:60]!r} is no mail address.", "recipients")
    if mail.user and mail.security is Security.NONE:
        raise BadChannel("A password must not travel unencrypted: choose tls or starttls.", "security")
