"""Pulls RTSP by libav: a thread that always drains, so that nothing piles up before us."""

from __future__ import annotations

from urllib.parse import quote, urlsplit, urlunsplit

import av

from hmi.cameras.addresses import target_of
from hmi.cameras.congestion import LEAST_SHARE, Congestion
from hmi.cameras.inbox import Inbox, Shot, Unit
from hmi.cameras.jpeg_header import MAX_BYTES, BadPicture, checked_size
from hmi.cameras.pull_http import PullFailed
from hmi.cameras.rtsp_guard import OPEN_S, RtspGuard
from hmi.cameras.sender_clock import SenderClock
from hmi.clock import mono_s
from hmi.domain.camera import Source

SILENT_S = 5.0
CODECS = ("h264", "hevc", "mjpeg")
OPTIONS = {
    "rtsp_transport": "tcp",
    "allowed_media_types": "video",  # no sound is asked for
    "protocol_whitelist": "rtsp,rtp,tcp",
    "fflags": "nobuffer",
    "flags": "low_delay",
    "max_delay": "0",
    "reorder_queue_size": "0",
    "analyzeduration": "1000000",
    "probesize": "500000",
}


class RtspPull:
    """One RTSP source. ``run`` blocks in a thread of its own until the source fails."""

    def __init__(self, source: Source, inbox: Inbox) -> None:
        self._source, self._inbox = source, inbox
        self.codec = ""
        self.can_pass = False
        self._clock: SenderClock | None = None
        self._congestion = Congestion(LEAST_SHARE)  # it cannot be asked for fewer pictures
        self._taken_ms = 0.0

    def run(self) -> None:
        """Pull until it fails; raises ``PullFailed``, ``BadAddress`` or ``av.FFmpegError``."""
        with RtspGuard(target_of(self._source.url, self._source.kind, self._source.nets)) as guard:
            self._clock = guard.clock
            try:
                self._read(self._with_user(guard.url))
            except av.FFmpegError as error:
                if guard.why:
                    raise PullFailed(guard.why) from error
                raise

    def _read(self, url: str) -> None:
        with av.open(url, options=OPTIONS, timeout=(OPEN_S, SILENT_S)) as container:
            if not container.streams.video:
                raise PullFailed("the camera sends no pictures")
            stream = container.streams.video[0]
            codec = stream.codec_context.name
            if codec not in CODECS:
                raise PullFailed(f"the camera sends {codec}, which is not read")
            self.can_pass = codec == "h264" and stream.codec_context.has_b_frames == 0
            self.codec = codec  # last: whoever sees it sees the rest
            repeat = None if codec == "mjpeg" else av.BitStreamFilterContext("dump_extra=freq=keyframe", stream)
            for packet in container.demux(stream):
                for whole in [packet] if repeat is None else repeat.filter(packet):
                    self._take(whole)
        raise PullFailed("the camera ended its stream")

    def ask_key(self) -> None:
        """RTSP has no word for it: the camera makes one when it likes."""

    def _take(self, packet: av.Packet[av.VideoStream]) -> None:
        if not packet.size:
            return
        now_ms = mono_s() * 1000
        waited_ms = 0.0 if self._clock is None else self._clock.waited_ms
        self._taken_ms = max(self._taken_ms + 1.0, now_ms - waited_ms)  # times never go back
        self._congestion.note(waited_ms, now_ms)
        if self._congestion.renewals:
            raise PullFailed("its pictures waited too long on their way")  # opened anew, what waits is thrown away
        if packet.size > MAX_BYTES or packet.is_corrupt:
            self._inbox.refuse("a broken picture" if packet.is_corrupt else "larger than 8 MB")
            return
        data = bytes(packet)
        if self.codec != "mjpeg":
            self._inbox.put_unit(Unit(data, self._taken_ms, packet.is_keyframe))
            return
        try:
            checked_size(data)
        except BadPicture as error:
            self._inbox.refuse(str(error))
        else:
            self._inbox.put(Shot(data, self._taken_ms, False))

    def _with_user(self, url: str) -> str:
        if not self._source.user:
            return url
        parts = urlsplit(url)
        who = f"{quote(self._source.user, safe='')}:{quote(self._source.password, safe='')}"
        return urlunsplit((parts.scheme, f"{who}@{parts.netloc}", parts.path, parts.query, ""))
