"""Pulls JPEGs by HTTP: the robot's own stream, any MJPEG stream, or a picture asked for again and again."""

from __future__ import annotations

import hashlib
import json
import ssl
import time
from collections.abc import Callable, Generator
from math import isfinite
from typing import Any
from urllib.parse import quote

import httpx

from hmi.cameras.addresses import Target, target_of
from hmi.cameras.congestion import Congestion
from hmi.cameras.inbox import Inbox, Shot
from hmi.cameras.jpeg_header import MAX_BYTES, BadPicture, checked_size
from hmi.cameras.multipart import MultipartReader, Part, boundary_of
from hmi.cameras.picture_wire import Plan
from hmi.cameras.transit import STEP_MS, Transit
from hmi.clock import mono_s
from hmi.domain.camera import Source, SourceKind

CONNECT_S = 4.0
SILENT_S = 5.0  # a stream that says nothing for so long is opened anew
PERIODS = 4  # for slower ones
MAX_AGE_MS = 60_000.0  # an age beyond that is a broken clock
ASK_AGAIN_MS = 5_000.0  # a request that was lost once and sent again makes the way look long: then it is asked anew


class PullFailed(Exception):
    """The source cannot be used now; the text is for people."""


class HttpPull:
    """One source by HTTP. ``run`` blocks in a thread of its own until the source fails.

    Args:
        plan_of: what is wanted now; the robot's stream is opened anew when limits change.
    """

    def __init__(self, source: Source, plan_of: Callable[[], Plan], inbox: Inbox) -> None:
        self._source, self._plan_of, self._inbox = source, plan_of, inbox
        self._rtt_ms = float("inf")
        self._connect_ms = 0.0
        self._transit, self._congestion = Transit(), Congestion()
        self._again_ms, self._patience_ms = 0.0, ASK_AGAIN_MS

    def run(self) -> None:
        """Pull until it fails; raises ``PullFailed``, ``BadAddress``, ``multipart.Refused`` or ``httpx.HTTPError``."""
        target = target_of(self._address(), self._source.kind, self._source.nets)
        silent_s = max(SILENT_S, PERIODS * self._source.expected_period_s)
        with httpx.Client(
            timeout=httpx.Timeout(silent_s, connect=CONNECT_S),
            follow_redirects=False,
            trust_env=False,
            verify=trust_for(target.url),
            auth=auth_of(self._source),
            headers=self._headers(target),
        ) as client:
            while True:
                if self._source.kind is SourceKind.SNAPSHOT:
                    self._snapshots(client, target)
                else:
                    self._stream(client, target)

    def ask_key(self) -> None:
        """Each JPEG can be decoded alone."""

    def _address(self) -> str:
        if self._source.kind is not SourceKind.ROBOT:
            return self._source.url
        return f"{self._source.url.rstrip('/')}/cameras/{quote(self._source.camera.id, safe='')}/stream"

    def _headers(self, target: Target) -> dict[str, str]:
        headers = {"Host": target.host, "User-Agent": "headland-cameras", "Accept-Encoding": "identity"}
        if self._source.token:
            headers["Authorization"] = f"Bearer {self._source.token}"
        return headers

    def _limits(self) -> dict[str, str]:
        if self._source.kind is not SourceKind.ROBOT:
            return {}
        plan = self._plan_of()
        limits = {"fps": f"{self._congestion.fps(plan.fps):g}"}
        return {**limits, "width": str(plan.width)} if plan.width else limits

    def _stream(self, client: httpx.Client, target: Target) -> None:
        limits, renewals = self._limits(), self._congestion.renewals
        self._transit.asked(_now_ms())
        with client.stream("GET", target.url, params=limits or None, extensions=self._extensions(target)) as response:
            _check(response)
            heard_ms = clock_ms_of(response.headers.get("x-asked-ms"))
            if heard_ms is not None:
                self._transit.heard(heard_ms)
            reader = MultipartReader(boundary_of(response.headers.get("content-type", "")))
            for data in response.iter_raw():
                for part in reader.feed(data, _now_ms()):
                    self._take(part)
                self._count(reader)
                if limits != self._limits() or renewals != self._congestion.renewals or self._transit.is_hidden:
                    return  # what waits in the robot goes with the connection
                if self._is_to_be_asked_again():
                    return
            raise PullFailed("the camera ended its stream")

    def _count(self, reader: MultipartReader) -> None:
        for _ in range(reader.too_large):
            self._inbox.refuse(f"larger than {MAX_BYTES // 1024 // 1024} MB")
        if reader.garbage:
            self._inbox.refuse("bytes that are no picture")
        reader.too_large = reader.garbage = 0

    def _take(self, part: Part) -> None:
        try:
            checked_size(part.body)
        except BadPicture as error:
            self._inbox.refuse(str(error))
            return
        age_ms = age_ms_of(part.headers.get("x-age-ms"))
        if age_ms is None:
            mark = hashlib.blake2b(part.body, digest_size=16).hexdigest()
            if mark == self._inbox.mark:  # a camera that hangs hands out its last picture for ever, opened anew too
                self._inbox.refuse("the same picture again")
                return
            self._inbox.mark = mark
            stamp_s = clock_ms_of(part.headers.get("x-timestamp"))
            waited_ms = 0.0 if stamp_s is None else self._waited_ms(stamp_s * 1000, part)
            self._inbox.put(Shot(part.body, part.began_ms - waited_ms, False))
            return
        taken_ms = clock_ms_of(part.headers.get("x-captured-ms"))
        waited_ms = 0.0 if taken_ms is None else self._waited_ms(taken_ms + age_ms, part)
        self._inbox.put(Shot(part.body, part.began_ms - age_ms - self._way_ms - waited_ms, True))

    def _waited_ms(self, begun_ms: float, part: Part) -> float:
        """Return how much longer than the quickest a part was under way, and ask less of a line that is full."""
        waited_ms = self._transit.waited_ms(begun_ms, part.began_ms)
        self._congestion.note(self._way_ms + waited_ms, part.began_ms)
        return waited_ms

    @property
    def _way_ms(self) -> float:
        """The most that the quickest was under way: there and back, or what the robot's own word for it tells more."""
        rtt_ms = 0.0 if self._rtt_ms == float("inf") else self._rtt_ms
        return (self._transit.way_ms or 0.0) if self._is_far(rtt_ms) else rtt_ms

    def _is_far(self, rtt_ms: float) -> bool:
        """Whether the way is longer than its round trip tells: who answers there is not the robot, or it was lost."""
        return self._transit.way_ms is not None and self._transit.way_ms - rtt_ms > STEP_MS

    def _is_to_be_asked_again(self) -> bool:
        if not self._is_far(self._rtt_ms):
            self._again_ms = 0.0
            return False
        now_ms = _now_ms()
        self._again_ms = self._again_ms or now_ms + self._patience_ms
        if now_ms < self._again_ms:
            return False
        self._again_ms, self._patience_ms = 0.0, 4 * self._patience_ms
        return True

    def _snapshots(self, client: httpx.Client, target: Target) -> None:
        period_s = max(self._source.expected_period_s, 1.0 / self._plan_of().fps)
        began_s = mono_s()
        self._transit.asked(began_s * 1000)
        with client.stream("GET", target.url, extensions=self._extensions(target)) as response:
            _check(response)
            at_ms, body = _now_ms(), bytearray()
            for data in response.iter_raw():
                body += data
                if len(body) > MAX_BYTES:
                    break
        self._take(Part(bytes(body), dict(response.headers), at_ms))
        time.sleep(max(0.0, period_s - (mono_s() - began_s)))

    def _extensions(self, target: Target) -> dict[str, Any]:
        return {"sni_hostname": target.hostname, "trace": self._trace}

    def _trace(self, event: str, _info: Any) -> None:
        """A connection takes one round trip to open; what is asked for is asked for when it is there."""
        if event == "http11.send_request_headers.started":
            self._transit.asked(_now_ms())
        elif event == "connection.connect_tcp.started":
            self._connect_ms = _now_ms()
        elif event == "connection.connect_tcp.complete":
            self._rtt_ms = min(self._rtt_ms, _now_ms() - self._connect_ms)


def auth_of(source: Source) -> httpx.Auth | None:
    """Return how to sign in where a user is set."""
    return EitherAuth(source.user, source.password) if source.user else None


class EitherAuth(httpx.Auth):
    """Digest where the camera offers it, basic where it offers only that."""

    def __init__(self, user: str, password: str) -> None:
        self._digest, self._basic = httpx.DigestAuth(user, password), httpx.BasicAuth(user, password)

    def auth_flow(self, request: httpx.Request) -> Generator[httpx.Request, httpx.Response, None]:
        """See ``httpx.Auth``."""
        response = yield request
        if response.status_code != 401:
            return
        if "digest" not in response.headers.get("www-authenticate", "").lower():
            yield from self._basic.auth_flow(request)
            return
        flow = self._digest.auth_flow(request)
        next(flow)  # its first request was sent already
        yield flow.send(response)


def trust_for(url: str) -> ssl.SSLContext:
    """Return whom to believe by TLS; plain addresses need nobody, and reading the list takes a tenth of a second."""
    return ssl.create_default_context() if url.startswith("https:") else ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)


def _check(response: httpx.Response) -> None:
    if response.status_code == 200:
        return
    raise PullFailed(_reason(response))


def _reason(response: httpx.Response) -> str:
    if known := reason_of(response.status_code):
        return known
    try:
        data = b""
        for piece in response.iter_raw():
            data += piece
            if len(data) > 4096:
                break
        return str(json.loads(data)["text"])[:200]
    except (ValueError, KeyError, TypeError, httpx.HTTPError):
        return f"the camera answers {response.status_code}"


def reason_of(status: int) -> str:
    """Return what an answer means whatever is in it, empty if that says nothing."""
    if status in (401, 403):
        return "the camera does not accept the password or token it was given"
    return "the camera sends elsewhere, which is not followed" if status in range(300, 400) else ""


def age_ms_of(said: str | None) -> float | None:
    """Return an age a header tells, ``None`` if it tells none that can be."""
    try:
        age = float(said) if said is not None else None
    except ValueError:
        return None
    return age if age is not None and 0 <= age <= MAX_AGE_MS else None


def clock_ms_of(said: str | None) -> float | None:
    """Return what a header tells of its robot's clock, ``None`` if it tells nothing."""
    try:
        at = float(said) if said is not None else float("nan")
    except ValueError:
        return None
    return at if isfinite(at) else None


def _now_ms() -> float:
    return mono_s() * 1000
