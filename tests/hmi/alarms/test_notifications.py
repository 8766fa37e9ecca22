"""Notifications: where they may go, what they say, that they keep to the rate and never show a secret."""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import json
import stat
import threading
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import pytest

from hmi.clock import FakeClock
from hmi.domain.alarm.live_alarm import What
from hmi.domain.alarm.priority import Priority
from hmi.notifications.address import AddressRules
from hmi.notifications.channel import Channel, Mail, Security, Webhook
from hmi.notifications.errors import BadAddress, BadChannel, NotDelivered
from hmi.notifications.message import Message, Told
from hmi.notifications.post import MAX_WAITING, PostOffice
from hmi.notifications.secret_box import SecretBox
from hmi.notifications.ways import deliver

ALL = frozenset(Priority)
LOCAL = AddressRules(is_private_allowed=True)


def hook(url: str = "https://hooks.example/x", **more: Any) -> Channel:
    """Return a webhook that tells of everything raised and escalated."""
    given = {"priorities": ALL, "steps": frozenset({What.RAISED, What.ESCALATED}), "per_hour": 60, **more}
    return Channel("hook", "Hook", True, Webhook(url), **given)  # type: ignore[arg-type]


def told(number: int = 1, priority: Priority = Priority.HIGH, what: What = What.RAISED) -> Told:
    """Return a step of an alarm."""
    at = datetime(2026, 5, 20, 14, 36, tzinfo=UTC)
    return Told(f"link-lost.weeder-{number:02d}", what, at, priority, f"weeder-{number:02d}", f"Weeder {number:02d}",
                "No data link", "Nothing heard.", ("Look before you walk up to it",))  # fmt: skip


class Outside:
    """The other side: takes messages, or fails as told."""

    def __init__(self) -> None:
        self.clock = FakeClock()
        self.got: list[Message] = []
        self.errors: list[Exception] = []
        self.post = PostOffice(self.clock, self.take)

    async def take(self, _channel: Channel, message: Message) -> None:
        """Take a message, or raise the next error."""
        if self.errors:
            raise self.errors.pop(0)
        self.got.append(message)

    async def run(self, seconds: int) -> None:
        """Let time pass a second at a time."""
        for _ in range(seconds):
            self.clock.advance(1)
            await self.post.send_due()


@pytest.mark.parametrize(
    "url",
    [
        "ftp://hooks.example/x",
        "file:///etc/passwd",
        "https://name:secret@hooks.example/",
        "https://",
        "http://169.254.169.254/latest/meta-data",
        "http://[::ffff:169.254.169.254]/",
        "http://[fe80::1]/",
        "http://0.0.0.0/",
        "http://[64:ff9b::a9fe:a9fe]/",
        "http://[fd00:ec2::254]/",
        "http://224.0.0.1/",
        "http://x.example:99999/",
    ],
)
def test_some_addresses_are_never_allowed(url: str) -> None:
    with pytest.raises(BadAddress, match=r"\.$"):
        LOCAL.check_url(url)


@pytest.mark.parametrize(
    "address", ["127.0.0.1", "10.1.2.3", "192.168.1.4", "172.16.0.1", "::1", "fd12::1", "100.64.0.1"]
)
def test_private_addresses_only_where_the_setting_allows_them(address: str) -> None:
    def find(rules: AddressRules) -> str:
        return rules.find("farm.example", 443).address

    assert find(AddressRules((), True, lambda _host, _port: [address])) == address
    with pytest.raises(BadAddress, match="notify_private"):
        find(AddressRules((), False, lambda _host, _port: [address]))


def test_one_bad_address_among_good_ones_is_enough_to_refuse() -> None:
    rules = AddressRules(resolve=lambda _host, _port: ["93.184.216.34", "169.254.169.254"])
    with pytest.raises(BadAddress, match="never allowed"):
        rules.find("two-faced.example", 80)


def test_only_named_hosts_where_some_are_named() -> None:
    rules = AddressRules((".farm.example", "hooks.example"))
    rules.check_host("mail.farm.example")
    rules.check_host("HOOKS.example.")
    for host in ("farm.example.evil.test", "evil-hooks.example", "xfarm.example"):
        with pytest.raises(BadAddress, match="notify_hosts"):
            rules.check_host(host)


async def test_each_channel_hears_what_it_asked_for() -> None:
    outside = Outside()
    outside.post.set_channels([hook(priorities=frozenset({Priority.CRITICAL}), robots=frozenset({"weeder-01"}))])
    outside.post.tell("Hof Brandt", told(1, Priority.CRITICAL))
    outside.post.tell("Hof Brandt", told(2, Priority.CRITICAL))
    outside.post.tell("Hof Brandt", told(1, Priority.HIGH))
    outside.post.tell("Hof Brandt", told(1, Priority.CRITICAL, What.RETURNED))
    await outside.run(1)
    assert [item.id for message in outside.got for item in message.items] == ["link-lost.weeder-01"]
    assert outside.got[0].subject == "Hof Brandt: Alarm, No data link, Weeder 01, priority 1"


async def test_a_flood_of_alarms_is_a_few_messages_that_list_them_all() -> None:
    outside = Outside()
    outside.post.set_channels([hook(per_hour=6)])
    for number in range(100):
        outside.post.tell("Hof Brandt", told(number))
        await outside.run(1)
    await outside.run(600)
    assert len(outside.got) <= 7
    assert sum(len(message.items) + message.left_out for message in outside.got) == 100


async def test_what_is_critical_is_named_in_a_flood_of_what_is_less() -> None:
    outside = Outside()
    outside.post.set_channels([hook(per_hour=1)])
    for number in range(70):
        outside.post.tell("Hof Brandt", told(number, Priority.MEDIUM))
    outside.post.tell("Hof Brandt", told(99, Priority.CRITICAL))
    outside.errors = [NotDelivered("No answer.")]
    await outside.run(3)
    [message] = outside.got
    assert json.loads(message.payload())["alarms"][0]["id"] == "link-lost.weeder-99"
    assert message.body().startswith("Alarm: No data link, Weeder 99, priority 1")
    assert "And 21 more." in message.body()


async def test_what_is_critical_outlasts_what_is_less_where_there_is_no_room() -> None:
    outside = Outside()
    outside.post.set_channels([hook(per_hour=600)])
    outside.errors = [NotDelivered("No answer.")]
    outside.post.tell("Hof Brandt", told(1, Priority.CRITICAL))
    await outside.run(1)
    outside.post.tell("Hof Brandt", told(2, Priority.CRITICAL))
    for number in range(3, 3 + MAX_WAITING + 50):
        outside.post.tell("Hof Brandt", told(number, Priority.LOW))
    assert outside.post.health()["hook"].dropped == 51
    await outside.run(20)
    ids = [item.id for message in outside.got for item in message.items]
    assert ids[:2] == ["link-lost.weeder-01", "link-lost.weeder-02"]
    assert ids[-1] == f"link-lost.weeder-{2 + MAX_WAITING + 50}", "and the newest of what is less"
    assert [one.id for one in outside.got[0].listed[:2]] == ids[:2]


async def test_what_is_critical_overdraws_the_rate_but_not_without_end() -> None:
    outside = Outside()
    outside.post.set_channels([hook(per_hour=1)])
    for number in range(100):
        outside.post.tell("Hof Brandt", told(number, Priority.CRITICAL))
        await outside.run(1)
    assert 10 <= len(outside.got) <= 16


async def test_what_is_not_taken_is_tried_again_and_nothing_is_sent_twice() -> None:
    outside = Outside()
    outside.errors = [NotDelivered("down."), NotDelivered("down.")]
    outside.post.set_channels([hook()])
    outside.post.tell("Hof Brandt", told(1))
    await outside.run(30)
    assert [len(message.items) for message in outside.got] == [1]
    health = outside.post.health()["hook"]
    assert (health.sent, health.failed, health.last_error) == (1, 0, "")


async def test_what_is_critical_does_not_share_the_last_try_of_an_older_message() -> None:
    outside = Outside()
    outside.errors = [NotDelivered("down.")] * 6
    outside.post.set_channels([hook()])
    outside.post.tell("Hof Brandt", told(1))
    while len(outside.errors) > 1:
        await outside.run(1)
    outside.post.tell("Hof Brandt", told(2, Priority.CRITICAL))
    await outside.run(1)
    assert outside.errors == [], "it did not wait for the older one's last try"
    await outside.run(30)
    assert [one.source for message in outside.got for one in message.items] == ["weeder-02"]
    health = outside.post.health()["hook"]
    assert (health.sent, health.failed, health.waiting) == (1, 1, 0)


async def test_a_channel_that_hangs_holds_up_no_other() -> None:
    hangs, got = asyncio.Event(), asyncio.Queue[str]()

    async def take(channel: Channel, _message: Message) -> None:
        if channel.id == "hook":
            await hangs.wait()
        await got.put(channel.id)

    post = PostOffice(FakeClock(), take)
    post.set_channels([hook(), replace(hook(), id="other")])
    post.start()
    for number in (1, 2):
        post.tell("Hof Brandt", told(number))
        assert await asyncio.wait_for(got.get(), 10) == "other"
    hangs.set()
    assert await asyncio.wait_for(got.get(), 10) == "hook"
    await post.stop()


async def test_a_refusal_for_good_is_not_repeated_and_is_remembered() -> None:
    outside = Outside()
    outside.errors = [NotDelivered("hooks.example answered 404.", is_lasting=True)]
    outside.post.set_channels([hook()])
    outside.post.tell("Hof Brandt", told(1))
    await outside.run(400)
    assert outside.got == []
    health = outside.post.health()["hook"]
    assert (health.failed, health.waiting, health.last_error) == (1, 0, "hooks.example answered 404.")


@pytest.mark.parametrize("mend", ["tested", "other address", "other secret", "off"])
async def test_a_channel_that_was_mended_or_switched_off_is_not_called_failing(mend: str) -> None:
    outside = Outside()
    outside.errors = [NotDelivered("hooks.example answered 404.", is_lasting=True)]
    outside.post.set_channels([hook()])
    outside.post.tell("Hof Brandt", told(1))
    await outside.run(1)
    assert outside.post.health()["hook"].failing_since_s is not None
    outside.post.set_channels([replace(hook(), name="The same by another name")])
    assert outside.post.health()["hook"].failing_since_s is not None
    changed = {
        "other address": hook("https://hooks.example/y"),
        "other secret": hook(secret="another"),
        "off": replace(hook(), is_on=False),
    }
    if mend == "tested":
        assert await outside.post.test(hook(), "Hof Brandt") == ""
    else:
        outside.post.set_channels([changed[mend]])
    health = outside.post.health()["hook"]
    assert (health.failing_since_s, health.last_error) == (None, "")


async def test_a_test_of_what_is_not_in_use_proves_nothing() -> None:
    outside = Outside()
    outside.errors = [NotDelivered("down.")]
    outside.post.set_channels([hook()])
    outside.post.tell("Hof Brandt", told(1))
    await outside.run(1)
    assert await outside.post.test(hook("https://hooks.example/y"), "Hof Brandt") == ""
    assert outside.post.health()["hook"].failing_since_s is not None


@pytest.mark.parametrize("between", [replace(hook(), is_on=False), hook("https://hooks.example/y")])
async def test_what_waited_is_sent_neither_after_a_channel_was_off_nor_elsewhere(between: Channel) -> None:
    outside = Outside()
    outside.errors = [NotDelivered("down.")]
    outside.post.set_channels([hook()])
    outside.post.tell("Hof Brandt", told(1))
    await outside.run(1)
    outside.post.tell("Hof Brandt", told(2))
    outside.post.set_channels([between])
    assert outside.post.health()["hook"].waiting == 0
    await outside.run(60)
    outside.post.set_channels([hook()])
    await outside.run(60)
    assert outside.got == []
    outside.post.tell("Hof Brandt", told(3))
    await outside.run(1)
    assert [item.source for message in outside.got for item in message.items] == ["weeder-03"]


async def test_a_message_that_fails_after_its_channel_was_changed_is_no_news_of_it() -> None:
    fails, under_way = asyncio.Event(), asyncio.Event()

    async def take(_channel: Channel, _message: Message) -> None:
        under_way.set()
        await fails.wait()
        raise NotDelivered("down.")

    post = PostOffice(FakeClock(), take)
    post.set_channels([hook()])
    post.tell("Hof Brandt", told(1))
    sending = asyncio.create_task(post.send_due())
    await asyncio.wait_for(under_way.wait(), 10)
    post.set_channels([hook("https://hooks.example/y")])
    fails.set()
    await sending
    health = post.health()["hook"]
    assert (health.waiting, health.failed, health.failing_since_s) == (0, 0, None)


async def test_an_outage_keeps_the_newest_in_bounded_memory() -> None:
    outside = Outside()
    outside.errors = [NotDelivered("down.")] * 3
    outside.post.set_channels([hook()])
    for number in range(MAX_WAITING * 3):
        outside.post.tell("Hof Brandt", told(number % 90))
    assert outside.post.health()["hook"].waiting <= MAX_WAITING
    assert outside.post.health()["hook"].dropped == MAX_WAITING * 2


class _Hook(BaseHTTPRequestHandler):
    status, got = 200, []  # type: ignore[var-annotated]

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["content-length"]))
        type(self).got.append((self.path, dict(self.headers), body))
        self.send_response(type(self).status)
        self.send_header("Location", "http://169.254.169.254/")
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Say nothing."""


@pytest.fixture
def server() -> Iterator[str]:
    """Return the address of a webhook on this machine."""
    _Hook.got, _Hook.status = [], 200
    site = HTTPServer(("127.0.0.1", 0), _Hook)
    thread = threading.Thread(target=site.serve_forever, args=(0.01,))
    thread.start()
    yield f"http://localhost:{site.server_port}/alarm?x=1"
    site.shutdown()
    thread.join()
    site.server_close()


async def test_a_webhook_gets_json_that_it_can_verify(server: str) -> None:
    await deliver(hook(server, secret="key"), Message("Hof Brandt", (told(7),)), LOCAL)
    path, headers, body = _Hook.got[0]
    assert path == "/alarm?x=1"
    assert headers["Host"].startswith("localhost:")
    assert headers["X-Headland-Signature"] == "sha256=" + hmac.new(b"key", body, hashlib.sha256).hexdigest()
    assert json.loads(body)["alarms"][0]["name"] == "Weeder 07"


async def test_a_redirect_is_not_followed_and_a_full_server_is_tried_later(server: str) -> None:
    for status, is_lasting in ((302, True), (404, True), (429, False), (503, False)):
        _Hook.status = status
        with pytest.raises(NotDelivered) as refused:
            await deliver(hook(server), Message("Hof Brandt", (told(),)), LOCAL)
        assert refused.value.is_lasting is is_lasting
    assert len(_Hook.got) == 4


async def test_this_machine_is_not_reached_without_the_setting(server: str) -> None:
    with pytest.raises(BadAddress, match="notify_private"):
        await deliver(hook(server), Message("Hof Brandt", (told(),)), AddressRules())
    assert _Hook.got == []


async def mail_server(got: list[bytes], refuses: bytes = b"nobody@") -> asyncio.Server:
    """Return a mail server that takes letters, but none for one recipient."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b"220 mail\r\n")
        is_data = False
        while line := await reader.readline():
            if is_data:
                got.append(line)
                if line == b".\r\n":
                    is_data = False
                    writer.write(b"250 taken\r\n")
                continue
            is_data = line.upper().startswith(b"DATA")
            is_refused = line.upper().startswith(b"RCPT") and refuses in line
            ends = b"354 go on" if is_data else b"221 bye" if line.upper().startswith(b"QUIT") else b"250 ok"
            writer.write((b"550 unknown" if is_refused else ends) + b"\r\n")
        writer.close()

    return await asyncio.start_server(serve, "127.0.0.1", 0)


def mail_to(server: asyncio.Server, *recipients: str) -> Channel:
    """Return a channel by this server."""
    port = server.sockets[0].getsockname()[1]
    mail = Mail("127.0.0.1", port, Security.NONE, "", "headland@farm.example", recipients)
    return Channel("mail", "Mail", True, mail, ALL, frozenset({What.RAISED}))


async def test_a_refused_recipient_is_named_though_the_others_have_it() -> None:
    got: list[bytes] = []
    async with await mail_server(got) as server:
        channel = mail_to(server, "anna@farm.example", "nobody@farm.example")
        with pytest.raises(NotDelivered, match=r"refused nobody@farm\.example") as refused:
            await deliver(channel, Message("Hof Brandt", (told(7),)), LOCAL)
    assert refused.value.is_lasting, "trying again would tell the others twice"
    assert got


async def test_a_mail_says_what_to_do_and_a_name_cannot_bend_its_head() -> None:
    got: list[bytes] = []
    server = await mail_server(got)
    channel = mail_to(server, "anna@farm.example")
    evil = Message("Hof\r\nBcc: evil@evil.test\r\nBrandt", (told(7, Priority.CRITICAL),))
    await deliver(channel, evil, LOCAL)
    server.close()
    letter = b"".join(got).decode()
    assert "\nBcc:" not in letter
    assert "Subject: Hof Bcc: evil@evil.test Brandt: Alarm, No data link" in letter.replace("\r\n ", " ")
    assert "1. Look before you walk up to it" in letter


def test_who_answers_for_the_robot_is_named_where_something_is_to_be_done() -> None:
    one = replace(told(what=What.ESCALATED), responsible="Martha Keller")
    assert "Responsible: Martha Keller" in Message("Hof", (one,)).body()
    assert json.loads(Message("Hof", (one,)).payload())["alarms"][0]["responsible"] == "Martha Keller"
    assert "Responsible" not in Message("Hof", (replace(one, what=What.RETURNED),)).body()


def test_a_password_must_not_travel_unencrypted() -> None:
    mail = Mail("mail.example", 25, Security.NONE, "anna", "a@farm.example", ("b@farm.example",))
    with pytest.raises(BadChannel, match="unencrypted"):
        Channel("mail", "Mail", True, mail, ALL, frozenset({What.RAISED})).check()


def test_secrets_are_sealed_with_a_key_that_only_its_owner_reads(tmp_path: Path) -> None:
    path = tmp_path / "keys" / "notifications.key"
    sealed = SecretBox(path).seal("correct horse")
    assert "correct horse" not in sealed
    assert SecretBox(path).open(sealed) == "correct horse"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    path.unlink()
    assert SecretBox(path).open(sealed) == ""
