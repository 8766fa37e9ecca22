"""One encoder each for H.264, VP8 and JPEG; made anew when the size of the pictures changes."""

from __future__ import annotations

from fractions import Fraction

import av
from av.video.frame import PictureType, VideoFrame

from hmi.cameras.jpeg_header import MAX_PIXELS

CLOCK = Fraction(1, 90_000)
KEY_EVERY_S = 2  # so that a clip begins near where it was asked to, and a lost keyframe request heals
BITS_PER_PIXEL = 4  # the ceiling: 1.2 Mbit/s at 640x480, 5 at 1280x960
_COLOURS = "colorprim=smpte170m:transfer=smpte170m:colormatrix=smpte170m"


class VideoEncoder:
    """H.264 (x264, baseline, one slice) or VP8, without delay."""

    def __init__(self, codec: str, fps: float) -> None:
        self._codec, self._fps = codec, max(1, round(fps))
        self._context: av.VideoCodecContext | None = None
        self._last_pts = -1

    def encode(self, frame: VideoFrame, captured_ms: float, *, is_key: bool) -> tuple[bytes, bool, int] | None:
        """Return data, whether it is a key picture, and its time at 90 kHz, which always grows."""
        context = self._context
        if context is None or (context.width, context.height) != (frame.width, frame.height):
            context = self._context = self._open(frame.width, frame.height)
        pts = max(self._last_pts + 1, round(captured_ms * 90))
        self._last_pts = pts
        frame.pts, frame.time_base = pts, CLOCK
        frame.pict_type = PictureType.I if is_key else PictureType.NONE
        packets = context.encode(frame)
        if not packets:
            return None
        return b"".join(bytes(packet) for packet in packets), any(packet.is_keyframe for packet in packets), pts

    def _open(self, width: int, height: int) -> av.VideoCodecContext:
        context = av.CodecContext.create(self._codec, "w")
        assert isinstance(context, av.VideoCodecContext)
        context.width, context.height, context.pix_fmt = width, height, "yuv420p"
        context.time_base, context.framerate = CLOCK, Fraction(self._fps, 1)
        context.thread_count = 1
        ceiling = max(300_000, BITS_PER_PIXEL * width * height)
        if self._codec == "libx264":
            context.profile = "Baseline"
            params = f"sliced-threads=0:scenecut=0:keyint={KEY_EVERY_S * self._fps}:{_COLOURS}"
            context.options = {
                "preset": "ultrafast",
                "tune": "zerolatency",
                "forced-idr": "1",
                "crf": "26",
                "maxrate": str(ceiling),
                "bufsize": str(ceiling),
                "x264-params": params,
            }
        else:
            context.bit_rate = ceiling
            context.gop_size = KEY_EVERY_S * self._fps
            context.options = {
                "deadline": "realtime",
                "cpu-used": "-12",
                "lag-in-frames": "0",
                "error-resilient": "1",
            }
        return context


class JpegEncoder:
    """JPEG of a decoded picture."""

    def __init__(self) -> None:
        self._context: av.VideoCodecContext | None = None

    def encode(self, frame: VideoFrame) -> bytes:
        """Return one picture; ``frame`` is yuvj420p."""
        context = self._context
        if context is None or (context.width, context.height) != (frame.width, frame.height):
            context = av.CodecContext.create("mjpeg", "w")
            assert isinstance(context, av.VideoCodecContext)
            context.width, context.height, context.pix_fmt = frame.width, frame.height, "yuvj420p"
            context.time_base = CLOCK
            context.thread_count = 1
            context.options = {"qmin": "3", "qmax": "6"}
            self._context = context
        frame.pts, frame.time_base, frame.pict_type = None, CLOCK, PictureType.NONE
        return b"".join(bytes(packet) for packet in context.encode(frame))


class Decoder:
    """JPEG or H.264 to pictures in yuv420p. One thread, and its frames never leave it."""

    def __init__(self, codec: str) -> None:
        context = av.CodecContext.create(codec, "r")
        assert isinstance(context, av.VideoCodecContext)
        context.thread_count = 1
        context.options = {"max_pixels": str(MAX_PIXELS)}  # no header of H.264 is judged before
        self._context = context

    def decode(self, data: bytes) -> VideoFrame | None:
        """Return the newest picture in ``data``; raises ``av.FFmpegError`` for what is none."""
        frames = self._context.decode(av.Packet(data))
        return frames[-1] if frames else None


def fitted(frame: VideoFrame, width: int, pixels: str) -> VideoFrame:
    """Return the picture in this pixel format and at most this wide (0: any), sides even."""
    share = 1.0 if not width or width >= frame.width else width / frame.width
    return frame.reformat(
        width=max(2, round(frame.width * share) & ~1),
        height=max(2, round(frame.height * share) & ~1),
        format=pixels,
        interpolation="FAST_BILINEAR" if share == 1.0 else "AREA" if share <= 0.5 else "BILINEAR",
    )
