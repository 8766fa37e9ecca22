"""What speaks to the context broker: client, mirror, missions, changes of the map; built by ``hmi.app.cloud``."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from pydantic import SecretStr

from backend_clients.http.retry import RetryPolicy
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker
from backend_clients.ngsi.errors import NgsiError
from backend_clients.ngsi.gate import Gate
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.subscription import Wanted
from backend_clients.ngsi.subscriptions import Subscriptions
from backend_clients.ngsi.tenant import Tenant
from backend_clients.ngsi.token import FixedHeader, OAuth2Settings, OAuth2Tokens, TokenSource
from hmi.api.cloud import CloudRefused
from hmi.api.router import PREFIX
from hmi.app.arrival_report import FromRobots
from hmi.app.cloud_report import CloudReport
from hmi.clock import Clock
from hmi.cloud.backlog import Backlog
from hmi.cloud.delays import Delays
from hmi.cloud.hints import Hints
from hmi.cloud.link import CloudLink, is_about_one
from hmi.cloud.map_changes import MapChanges
from hmi.cloud.map_subscription import IsOurs, MapSubscription
from hmi.cloud.marker import Marker, where_of
from hmi.cloud.mirror import Mirror
from hmi.cloud.missions import CloudMissions
from hmi.cloud.newest import Newest
from hmi.cloud.proposals import ProposalBook
from hmi.cloud.refused import RefusedFile, RefusedRecords
from hmi.cloud.secret import kept_secret
from hmi.cloud.states import RobotStates
from hmi.cloud.told_ids import ToldIds
from hmi.fiware.map_change import KIND_OF
from hmi.fiware.urn import KeyValues, Urns
from hmi.mapping.feature import MapFeature
from hmi.service_link import ServiceLink
from hmi.settings import Settings
from hmi.store.fleet import FleetStore

TIMEOUT_S = 8.0


@dataclass(frozen=True, slots=True)
class WorkParts:
    """What the room has."""

    settings: Settings
    clock: Clock
    urns: Urns
    fleet: FleetStore
    backlog: Backlog
    book: ProposalBook
    robots: FromRobots
    client: NgsiClient
    link: ServiceLink
    others: Callable[[], Sequence[Newest]]


class CloudWork:
    """Everything with the broker at its other end.

    Args:
        whole: the farm's map and missions, as far as they may be told.
        published: the published map by id.
        on_proposals: called when proposals came, went or changed.
    """

    def __init__(
        self,
        parts: WorkParts,
        whole: Callable[[], Awaitable[Sequence[KeyValues]]],
        published: Callable[[], Awaitable[Mapping[str, MapFeature]]],
        on_proposals: Callable[[], None],
    ) -> None:
        self._parts = parts
        settings, clock, urns = parts.settings, parts.clock, parts.urns
        client = parts.client
        ref = EntityRef(urns.of("Headland", "console"), "Headland")
        is_demo = settings.demo and settings.demo_cloud
        marker = Marker(settings.data / "cloud" / "console.json", ref, settings.farm_name, is_strict=not is_demo)
        link, states = CloudLink(client, marker, clock, parts.link), RobotStates(parts.fleet, urns, clock)
        is_ours = partial(marker.is_ours, client)
        changes = self._make_changes(client, published, on_proposals, is_ours)
        self.refused = RefusedRecords(RefusedFile(settings.data / "cloud" / "refused.db"), clock)
        self.mirror = Mirror(link, states, parts.backlog, clock, whole, changes, parts.others, refused=self.refused)
        read_back = Delays()
        self.missions = CloudMissions(
            client, urns.farm_name, clock, read_back, is_ours=is_ours, is_away=lambda: parts.link.is_away
        )
        self.report = CloudReport(settings, clock, self.mirror, parts.backlog, parts.book, read_back, parts.robots)

    @property
    def hints(self) -> Hints | None:
        """Who takes notifications, ``None`` where the broker cannot reach this console."""
        return self.mirror.changes.hints if self.mirror.changes is not None else None

    async def round(self) -> None:
        """Do what is due now, in one task."""
        await self.mirror.guard.run("Everything", self._round)

    async def _round(self) -> bool:
        await self.mirror.round()
        link = self.mirror.link
        if link.link.is_well:  # the tenant is ours, too
            try:
                await self.missions.tidy()
            except NgsiError as error:
                if not is_about_one(error):
                    link.failed(error)
        return True

    async def take_tenant(self) -> None:
        """Keep the farm in this tenant from now on; raises ``CloudRefused``."""
        try:
            await self.mirror.link.take_tenant()
        except NgsiError as error:
            raise CloudRefused(f"The cloud did not take it: {error}. {error.mend}") from error

    async def close(self) -> None:
        """Close the connection and what is on disk."""
        await self.refused.close()
        await self.mirror.link.client.close()

    def _make_changes(
        self,
        client: NgsiClient,
        published: Callable[[], Awaitable[Mapping[str, MapFeature]]],
        on_proposals: Callable[[], None],
        is_ours: IsOurs,
    ) -> MapChanges:
        settings, clock = self._parts.settings, self._parts.clock
        hints, subscription = None, None
        if settings.cloud_notify_url:
            secret = SecretStr(kept_secret(settings.data / "cloud" / "notify.secret"))
            hints = Hints(Gate(secret, settings.cloud_notify_from), client.connection.broker.tenant, clock)
            subscriptions = Subscriptions(client.connection, f"console-{self._parts.urns.farm_name}"[:60])
            url = f"{settings.cloud_notify_url}{PREFIX}/cloud/notify/{secret.get_secret_value()}"
            wanted = Wanted(key="map", url=url, types=tuple(KIND_OF))
            subscription = MapSubscription(subscriptions, wanted, clock, is_ours)
        told = ToldIds(settings.data / "cloud" / "told.json", where_of(client.connection.broker))
        book = self._parts.book
        return MapChanges(client, book, hints, clock, published, on_proposals, subscription, told, is_ours=is_ours)


def make_client(settings: Settings) -> NgsiClient:
    """Return the client; reads certificates, so not on the event loop. Raises ``BadInput`` for unusable settings."""
    return NgsiClient(_broker(settings), _tokens(settings))


def _broker(settings: Settings) -> Broker:
    assert settings.cloud_url is not None
    return Broker(
        settings.cloud_url,
        Tenant(settings.cloud_tenant, settings.cloud_path),
        ca=_file(settings.cloud_ca),
        timeout_s=TIMEOUT_S,
        retry=RetryPolicy(attempts=1),  # the mirror itself tries again, with what is newest then
    )


def _tokens(settings: Settings) -> TokenSource | None:
    if settings.cloud_oauth_url:
        return OAuth2Tokens(
            OAuth2Settings(
                url=settings.cloud_oauth_url,
                client_id=settings.cloud_oauth_client,
                client_secret=settings.cloud_oauth_secret,
                username=settings.cloud_oauth_user,
                password=settings.cloud_oauth_password,
                header=settings.cloud_token_header,
                ca=_file(settings.cloud_ca),
            )
        )
    if settings.cloud_token.get_secret_value():
        return FixedHeader(settings.cloud_token, settings.cloud_token_header)
    return None


def _file(path: Path | None) -> str:
    return "" if path is None else str(path)
