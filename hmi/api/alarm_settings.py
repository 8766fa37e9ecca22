"""Who is notified of alarms, and after how long nobody's answer escalates. For admins."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path
from pydantic import Field

from hmi.api.access import SignedIn
from hmi.api.body import Body, Id, Line, Name, Secret
from hmi.api.errors import ApiError
from hmi.commands.alarm_settings_desk import AlarmSettingsDesk
from hmi.notifications.book import channel_of
from hmi.notifications.channel import MAX_CHANNELS, MAX_RECIPIENTS
from hmi.notifications.errors import BadChannel

ChannelId = Annotated[str, Path(max_length=64)]
After = Annotated[float | None, Field(ge=10, le=86_400)]


class _Told(Body):
    id: Id
    name: Name
    is_on: bool = True
    priorities: Annotated[list[Literal[1, 2, 3, 4]], Field(min_length=1, max_length=4)]
    steps: Annotated[
        list[Literal["raised", "escalated", "returned", "acknowledged"]], Field(min_length=1, max_length=4)
    ]
    robots: Annotated[list[Id], Field(default_factory=list, max_length=200)]
    per_hour: Annotated[int, Field(ge=1, le=600)] = 30
    secret: Secret | None = None


class WebhookBody(_Told):
    """A POST of JSON; with a secret it is signed. Null keeps the secret, an empty one removes it."""

    kind: Literal["webhook"]
    url: Annotated[str, Field(min_length=8, max_length=500)]


class MailBody(_Told):
    """A mail; the secret is the password."""

    kind: Literal["email"]
    host: Annotated[str, Field(min_length=1, max_length=253)]
    port: Annotated[int, Field(ge=1, le=65535)] = 587
    security: Literal["tls", "starttls", "none"] = "starttls"
    user: Line = ""
    sender: Line
    recipients: Annotated[list[Line], Field(min_length=1, max_length=MAX_RECIPIENTS)]


class EscalationBody(Body):
    """Seconds without an answer by priority; null is never."""

    p1: Annotated[After, Field(alias="1")] = 60
    p2: Annotated[After, Field(alias="2")] = 300
    p3: Annotated[After, Field(alias="3")] = 1800
    p4: Annotated[After, Field(alias="4")] = None


class NotificationsBody(Body):
    """Everything; what is left out goes, what is null stays. ``revision`` of the view it was made from."""

    channels: (
        Annotated[list[Annotated[WebhookBody | MailBody, Field(discriminator="kind")]], Field(max_length=MAX_CHANNELS)]
        | None
    )
    escalate_after_s: EscalationBody | None = EscalationBody()
    revision: Annotated[int | None, Field(ge=0)] = None


def alarm_settings_routes(desk: AlarmSettingsDesk) -> APIRouter:
    """Return the routes of notifications."""
    router = APIRouter(tags=["alarms"])

    @router.get("/alarms/notifications", summary="Channels and limits; secrets are never shown")
    async def view(session: SignedIn) -> dict[str, Any]:
        return desk.view(session)

    @router.put("/alarms/notifications", summary="Replace channels and limits")
    async def change(body: NotificationsBody, session: SignedIn) -> dict[str, Any]:
        channels = None if body.channels is None else [channel_of(one.model_dump()) for one in body.channels]
        secrets = {one.id: one.secret for one in body.channels or ()}
        after = None if body.escalate_after_s is None else body.escalate_after_s.model_dump(by_alias=True)
        try:
            return await desk.change(session, channels, secrets, after, body.revision)
        except BadChannel as error:
            raise ApiError(422, "invalid", error.text, error.field) from error

    @router.post("/alarms/notifications/{channel_id}/test", summary="Send a test by one channel")
    async def test(channel_id: ChannelId, session: SignedIn) -> dict[str, Any]:
        is_ok, text = await desk.test(session, channel_id)
        return {"ok": is_ok, "text": text}

    return router
