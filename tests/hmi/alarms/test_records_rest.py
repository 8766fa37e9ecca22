"""One alarm with what happened around it, journal, figures and settings, by REST."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy.orm import Session

from hmi.api.alarm_records import AlarmRecordRoutes, alarm_record_routes
from hmi.api.alarm_settings import alarm_settings_routes
from hmi.api.alarms import AlarmRoutes, alarm_routes
from hmi.commands.alarm_desk import AlarmDesk
from hmi.commands.alarm_settings_desk import MASK, AlarmSettingsDesk, SettingsParts
from hmi.domain.alarm.alarm import AlarmKey
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Change, Turn
from hmi.domain.alarm.finding import Finding
from hmi.domain.alarm.journal import Line
from hmi.domain.alarm.priority import Priority
from hmi.domain.role import Role
from hmi.notifications.address import AddressRules
from hmi.notifications.book import ChannelBook
from hmi.notifications.channel import Channel, Webhook
from hmi.notifications.errors import NotDelivered
from hmi.notifications.message import Message
from hmi.notifications.post import PostOffice
from hmi.notifications.secret_box import SecretBox
from hmi.presenters.scene import Scene
from hmi.store.alarm_journal import AlarmJournal, Search
from hmi.store.alarm_records import AlarmRecords
from hmi.store.alarm_settings import AlarmSettings
from hmi.store.alarms import AlarmStore
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.errors import DatabaseUnavailable
from hmi.store.history import History
from tests.hmi.api.conftest import migrated as migrated
from tests.hmi.api.console import Console
from tests.hmi.commands.field import FARM

LINK, STOP = "link-lost.weeder-01", "stop-not-confirmed.weeder-01"
HOOK = {"id": "hook", "name": "Control room", "kind": "webhook", "url": "https://hooks.example/x", "priorities": [1, 2],
        "steps": ["raised", "escalated"], "secret": "a signing key"}  # fmt: skip
MAIL = {"id": "mail", "name": "Anna", "kind": "email", "host": "mail.example", "sender": "headland@farm.example",
        "recipients": ["anna@farm.example"], "user": "headland", "priorities": [1], "steps": ["escalated"],
        "secret": "mail password"}  # fmt: skip


class RecordConsole(Console):
    """A console with alarms that are kept."""

    def _services(self) -> Any:
        services = super()._services()
        clock = self.field.clock
        self.alarms = AlarmStore(clock, catalogue())
        self.kept = AlarmRecords(self.database, FARM, lambda live: ("Weeder 01", live.type.title), linger_s=0.0)
        self.alarms.listeners.append(self.kept.take)
        self.delivered: list[Message] = []
        self.problem = ""
        desk = AlarmDesk(self.alarms, self.audit, self.authorize, clock, lambda i: i != "console", clock.utc)
        self.settings = AlarmSettings(self.database, FARM)
        self.box = SecretBox(self.folder / "keys" / "notifications.key")
        self.settings_desk = AlarmSettingsDesk(
            SettingsParts(self.alarms, self.settings, ChannelBook(self.settings, self.box, clock),
                          PostOffice(clock, self._deliver), AddressRules(), self.database, self.audit, self.authorize,
                          clock, "Hof Brandt")
        )  # fmt: skip
        about = AlarmRecordRoutes(
            store=self.alarms,
            journal=AlarmJournal(self.database, FARM),
            history=History(self.database, FARM),
            audit=self.audit,
            database=self.database,
            clock=clock,
            name_of=lambda _source: "Weeder 01",
            scene_of=lambda source: Scene(clock.mono_s(), self.field.robot(source)),
            contact_of=lambda _source: {"name": "Jonas Weber", "phone": "+49 1"},
            responsible_for=lambda _source: "Martha Keller",
            per_operator_hour=lambda: 4.0,
        )
        live = AlarmRoutes(self.alarms, desk, clock, lambda _source: "Weeder 01")
        routes = [alarm_settings_routes(self.settings_desk), alarm_routes(live), alarm_record_routes(about)]
        object.__setattr__(services, "further", routes)
        return services

    async def _deliver(self, _channel: Channel, message: Message) -> None:
        if self.problem:
            raise NotDelivered(self.problem)
        self.delivered.append(message)

    def come(self, code: str, **more: Any) -> None:
        """Let a condition come."""
        self.alarms.apply([Change(Turn.COMES, AlarmKey(code, "weeder-01"), Finding(code, "so", **more))])


@pytest.fixture
async def console(tmp_path: Path, migrated: Path) -> AsyncIterator[RecordConsole]:
    """Return a console with one robot whose stop was not confirmed after its link was lost."""
    console = RecordConsole(tmp_path, migrated)
    await console.database.run(console.register)
    console.kept.start()
    console.come("link-lost", since_s=console.field.clock.mono_s())
    console.field.clock.advance(0.5)
    console.audit.append(AuditEntry(FARM, "Martha Keller", "Tablet 3", "stop", "sent", "weeder-01", "stop-1"))
    console.field.clock.advance(1)
    console.come("stop-not-confirmed")
    await asyncio.to_thread(console.kept.flush)
    await console.database.run(console.audit.flush)
    yield console
    await asyncio.to_thread(console.kept.close)
    await console.close()


async def test_one_alarm_says_what_to_do_and_what_happened_in_order(console: RecordConsole) -> None:
    viewer = await console.browser(Role.VIEWER)
    answer = (await viewer.get(f"/alarms/{STOP}")).json()
    assert answer["type"]["steps"][0] == "Use the red button on the machine"
    assert [(one["text"], one["is_first"]) for one in answer["sequence"]] == [
        ("No data link", True),
        ("STOP pressed, Martha Keller, Tablet 3", False),
        ("Stop not confirmed", False),
    ]
    assert all(one["at"] % 10 == 0 for one in answer["sequence"])
    assert (answer["seen_before"], answer["contact"]["name"]) == (0, "Jonas Weber")
    assert answer["responsible"] == "Martha Keller"
    assert (await viewer.get("/alarms/link-lost.weeder-99")).status_code == 404


async def test_a_guided_check_says_what_it_found_and_changes_nothing(console: RecordConsole) -> None:
    viewer = await console.browser(Role.VIEWER)
    before = (await viewer.get("/alarms")).json()["alarms"]
    found = (await viewer.post(f"/alarms/{LINK}/diagnose")).json()
    assert {"text": "Is the console connected to the broker?", "found": "Yes.", "ok": True} in found["steps"]
    assert found["conclusion"].endswith(".")
    assert (await viewer.get("/alarms")).json()["alarms"] == before


async def test_the_journal_is_searched_and_exported(console: RecordConsole) -> None:
    viewer = await console.browser(Role.VIEWER)
    lines = (await viewer.get("/alarms/journal?q=stop&priority=1")).json()["lines"]
    assert [(one["what"], one["id"]) for one in lines] == [("raised", STOP)]
    table = await viewer.get("/alarms/journal.csv")
    assert table.headers["content-type"].startswith("text/csv")
    assert table.text.splitlines()[0].lstrip("\ufeff").startswith("utc,what,priority")
    assert len(table.text.splitlines()) == 3
    assert (await viewer.get("/alarms/journal?from=2026-01-01T00:00:00")).status_code == 422


class LongJournal(AlarmJournal):
    """A journal of so many lines, that are made when they are asked for."""

    def __init__(self, database: Database, count: int) -> None:
        super().__init__(database, FARM)
        self._count = count

    def page(self, _search: Search, limit: int, before: int | None = None) -> list[Line]:
        """See ``AlarmJournal``."""
        newest = self._count if before is None else before - 1
        at = datetime(2026, 5, 4, tzinfo=UTC)
        return [Line(number, at, STOP, "stop-not-confirmed", "weeder-01", "", "", "raised", 1, "", "", "")
                for number in range(newest, max(newest - limit, 0), -1)]  # fmt: skip


@pytest.mark.parametrize("count", [0, 1000, 1001, 150_000])
def test_an_export_ends_with_the_oldest_line_however_many_there_are(console: RecordConsole, count: int) -> None:
    pages = list(LongJournal(console.database, count).export(Search()))
    assert [line.id for page in pages for line in page] == list(range(count, 0, -1))


async def test_the_figures_of_two_alarms(console: RecordConsole) -> None:
    figures = (await (await console.browser(Role.VIEWER)).get("/alarms/statistics")).json()
    assert (figures["last_10min"], figures["unacknowledged"], figures["shelved"]) == (2, 2, 0)
    assert len(figures["per_10min"]) == 48
    assert figures["mix_7d"] == {"1": 0.5, "2": 0.5, "3": 0.0, "4": 0.0}
    assert figures["answer_median_s"] is None
    assert figures["per_operator_hour"] == 4.0


async def test_only_admins_see_and_change_who_is_notified(console: RecordConsole) -> None:
    anna = await console.browser(Role.SUPERVISOR)
    for call in (anna.get("/alarms/notifications"), anna.put("/alarms/notifications", json={"channels": []}),
                 anna.post("/alarms/notifications/hook/test")):  # fmt: skip
        assert (await call).status_code == 403


async def test_a_secret_goes_in_and_never_comes_out(console: RecordConsole) -> None:
    admin = await console.browser(Role.ADMIN)
    put = await admin.put("/alarms/notifications", json={"channels": [HOOK, MAIL], "escalate_after_s": {"1": 30}})
    assert put.status_code == 200, put.text
    shown = (await admin.get("/alarms/notifications")).text
    assert "a signing key" not in shown
    assert [one["secret"] for one in put.json()["channels"]] == [MASK, MASK]
    assert put.json()["escalate_after_s"]["1"] == 30
    assert console.alarms.escalate_after_s[Priority.CRITICAL] == 30
    stored = str(await console.database.run(console.settings.get, "notifications"))
    written = str([one.data for one in await console.written("alarm_settings")])
    for place in (stored, written):
        assert "signing" not in place
        assert "mail password" not in place
    book = ChannelBook(console.settings, console.box, console.field.clock)
    assert [one.secret for one in await console.database.run(book.load)] == ["a signing key", "mail password"]


async def test_a_secret_stays_while_its_address_stays_and_goes_with_it(console: RecordConsole) -> None:
    admin = await console.browser(Role.ADMIN)
    await admin.put("/alarms/notifications", json={"channels": [HOOK]})
    again = {**HOOK, "secret": None, "name": "Other name"}
    kept = (await admin.put("/alarms/notifications", json={"channels": [again]})).json()
    assert kept["channels"][0]["secret"] == MASK
    moved = {**HOOK, "secret": MASK, "url": "https://evil.example/x"}
    gone = (await admin.put("/alarms/notifications", json={"channels": [moved]})).json()
    assert gone["channels"][0]["secret"] == ""


async def test_the_path_of_an_address_is_as_secret_as_a_password_and_stays_while_it_is_shown(
    console: RecordConsole,
) -> None:
    admin = await console.browser(Role.ADMIN)
    hook = {**HOOK, "url": "https://hooks.example:8443/T0/B0/token?key=1"}
    (shown,) = (await admin.put("/alarms/notifications", json={"channels": [hook]})).json()["channels"]
    assert shown["url"] == "https://hooks.example:8443/…"
    stored = str(await console.database.run(console.settings.get, "notifications"))
    written = str([one.data for one in await console.written("alarm_settings")])
    assert "token" not in stored + written + (await admin.get("/alarms/notifications")).text
    again = {**hook, "name": "Other name", "url": shown["url"], "secret": None}
    assert (await admin.put("/alarms/notifications", json={"channels": [again]})).status_code == 200
    book = ChannelBook(console.settings, console.box, console.field.clock)
    (kept,) = await console.database.run(book.load)
    assert (kept.name, kept.way) == ("Other name", Webhook(hook["url"]))
    other = {**hook, "id": "another", "url": shown["url"]}
    refused = await admin.put("/alarms/notifications", json={"channels": [again, other]})
    assert (refused.status_code, refused.json()["field"]) == (422, "url")


async def test_an_address_kept_before_addresses_were_sealed_still_works(console: RecordConsole) -> None:
    admin = await console.browser(Role.ADMIN)
    await admin.put("/alarms/notifications", json={"channels": [HOOK]})
    stored = await console.database.run(console.settings.get, "notifications")
    (old,) = stored["channels"]
    del old["address"]
    old["url"] = HOOK["url"]
    await console.database.run(console.settings.put, "notifications", stored, "ana", console.field.clock.utc())
    book = ChannelBook(console.settings, console.box, console.field.clock)
    (kept,) = await console.database.run(book.load)
    assert kept.way == Webhook(HOOK["url"])


async def test_an_address_inside_the_network_is_refused_with_the_reason(console: RecordConsole) -> None:
    admin = await console.browser(Role.ADMIN)
    refused = await admin.put("/alarms/notifications", json={"channels": [{**HOOK, "url": "http://127.0.0.1:8080/"}]})
    assert (refused.status_code, refused.json()["field"]) == (422, "url")
    assert "notify_private" in refused.json()["text"]
    assert (await admin.get("/alarms/notifications")).json()["channels"] == []


async def test_who_saves_what_was_loaded_before_somebody_else_saved_is_refused(console: RecordConsole) -> None:
    admin, other = await console.browser(Role.ADMIN), await console.browser(Role.ADMIN)
    seen = (await other.get("/alarms/notifications")).json()["revision"]
    first = await admin.put("/alarms/notifications", json={"channels": [HOOK], "revision": seen})
    assert first.json()["revision"] != seen
    late = await other.put("/alarms/notifications", json={"channels": [MAIL], "revision": seen})
    assert (late.status_code, late.json()["code"]) == (409, "changed")
    assert late.json()["text"] == "Somebody changed it meanwhile."
    kept = (await other.get("/alarms/notifications")).json()
    assert [one["id"] for one in kept["channels"]] == ["hook"]
    again = {"channels": [{**HOOK, "secret": None}, MAIL], "escalate_after_s": None, "revision": kept["revision"]}
    both = (await other.put("/alarms/notifications", json=again)).json()
    assert [one["id"] for one in both["channels"]] == ["hook", "mail"]
    assert both["channels"][0]["secret"] == MASK


async def test_of_two_who_save_at_once_one_is_refused(console: RecordConsole) -> None:
    admin, other = await console.browser(Role.ADMIN), await console.browser(Role.ADMIN)
    answers = await asyncio.gather(
        admin.put("/alarms/notifications", json={"channels": [HOOK], "revision": 0}),
        other.put("/alarms/notifications", json={"channels": [MAIL], "revision": 0}),
    )
    assert sorted(one.status_code for one in answers) == [200, 409]


async def test_saving_the_seconds_leaves_the_channels_and_the_other_way_round(console: RecordConsole) -> None:
    admin = await console.browser(Role.ADMIN)
    await admin.put("/alarms/notifications", json={"channels": [HOOK], "escalate_after_s": {"1": 30}})
    seconds = await admin.put("/alarms/notifications", json={"channels": None, "escalate_after_s": {"1": 45}})
    assert [one["secret"] for one in seconds.json()["channels"]] == [MASK]
    left = await admin.put("/alarms/notifications", json={"channels": [], "escalate_after_s": None})
    assert (left.json()["channels"], left.json()["escalate_after_s"]["1"]) == ([], 45)


async def test_what_was_loaded_before_a_restart_is_known_for_old_after_it(console: RecordConsole) -> None:
    admin = await console.browser(Role.ADMIN)
    saved = (await admin.put("/alarms/notifications", json={"channels": [HOOK]})).json()["revision"]
    await console.settings_desk.load()
    assert (await admin.get("/alarms/notifications")).json()["revision"] == saved > 0


async def test_channels_and_seconds_are_kept_together_or_not_at_all(
    console: RecordConsole, monkeypatch: pytest.MonkeyPatch
) -> None:
    admin = await console.browser(Role.ADMIN)
    await admin.put("/alarms/notifications", json={"channels": [HOOK], "escalate_after_s": {"1": 30}})
    merge = Session.merge

    def full(session: Session, row: Any) -> Any:
        if row.name == "escalation":
            raise DatabaseUnavailable("the disk is full")
        return merge(session, row)

    monkeypatch.setattr(Session, "merge", full)
    failed = await admin.put("/alarms/notifications", json={"channels": [MAIL], "escalate_after_s": {"1": 45}})
    assert failed.status_code == 503
    monkeypatch.undo()
    await console.settings_desk.load()
    kept = (await admin.get("/alarms/notifications")).json()
    assert ([one["id"] for one in kept["channels"]], kept["escalate_after_s"]["1"]) == (["hook"], 30)


async def test_a_test_says_whether_the_other_side_took_it(console: RecordConsole) -> None:
    admin = await console.browser(Role.ADMIN)
    await admin.put("/alarms/notifications", json={"channels": [HOOK]})
    assert (await admin.post("/alarms/notifications/hook/test")).json()["ok"] is True
    assert console.delivered[0].is_test
    console.problem = "hooks.example answered 503."
    failed = (await admin.post("/alarms/notifications/hook/test")).json()
    assert failed == {"ok": False, "text": "hooks.example answered 503."}
    assert (await admin.post("/alarms/notifications/other/test")).status_code == 404
