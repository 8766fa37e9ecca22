"""What is said to the camera process, as its protocol has it, and what its answers mean."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import httpx
import pytest

from hmi.app.camera_calls import CameraCalls
from hmi.commands.camera_ports import CamerasAway, Clip, NoPicture, Still

PATH = Path("/data/pictures/incoming/x.mp4")
WRITTEN = {"path": str(PATH), "from": 940_000.0, "to": 1_015_000.0, "pictures": 375, "bytes": 9, "width_px": 640,
           "height_px": 480, "has_gap": True}  # fmt: skip


class Process:
    """Answers as told and notes what was asked."""

    def __init__(self, status: int = 200, body: Any = None, **headers: str) -> None:
        content = body if isinstance(body, bytes) else json.dumps(body).encode()
        self._answer = httpx.Response(status, content=content, headers=headers)
        self.asked: list[tuple[str, str, Any]] = []

    async def __call__(self, method: str, path: str, content: bytes | None, limit_s: float) -> httpx.Response:
        """Answer."""
        assert limit_s > 0
        self.asked.append((method, path, content))
        return self._answer


async def test_a_still_comes_with_its_capture_time() -> None:
    process = Process(200, b"jpeg", **{"X-Headland-Captured": "1000250.5"})
    assert await CameraCalls(process).still("weeder-01", "front", 1.0) == Still(b"jpeg", 1000.2505)
    assert process.asked == [("GET", "/cameras/weeder-01/front/still?fresh_s=1", None)]
    await CameraCalls(process).still("weeder-01", "front", 1.0, is_full=True)
    assert process.asked[-1][1] == "/cameras/weeder-01/front/still?fresh_s=1&full=true"
    await CameraCalls(process).still("weeder-01", "front", None)
    assert process.asked[-1][1] == "/cameras/weeder-01/front/still"


async def test_a_camera_that_tells_no_time_is_known_as_such() -> None:
    process = Process(200, b"jpeg", **{"X-Headland-Captured": "1000250.5", "X-Headland-Dated": "0"})
    assert (await CameraCalls(process).still("weeder-01", "front", None)).is_dated is False
    written = Process(201, {**WRITTEN, "is_dated": False})
    assert (await CameraCalls(written).clip("weeder-01", "front", 940.0, 1015.0, PATH)).is_dated is False


async def test_a_camera_that_opens_late_is_asked_twice_and_one_that_is_not_there_once() -> None:
    late, unknown = Process(404, {"code": "no_picture"}), Process(404, {"code": "unknown_camera"})
    for process, count in ((late, 2), (unknown, 1)):
        with pytest.raises(NoPicture):
            await CameraCalls(process).still("weeder-01", "front", 1.0)
        assert len(process.asked) == count


async def test_a_clip_is_asked_for_in_milliseconds_and_told_in_seconds() -> None:
    process = Process(201, WRITTEN)
    clip = await CameraCalls(process).clip("weeder-01", "front", 940.0, 1015.0, PATH)
    assert clip == Clip(940.0, 1015.0, 640, 480, has_gap=True)
    (asked,) = process.asked
    wish = {"robot": "weeder-01", "camera": "front", "from": 940_000.0, "to": 1_015_000.0, "path": str(PATH)}
    assert (asked[0], asked[1], json.loads(asked[2])) == ("POST", "/clips", wish)


async def test_the_whole_list_of_what_is_held_is_said() -> None:
    process = Process(204, b"")
    await CameraCalls(process).record([("weeder-01", "front")])
    wish = {"cameras": [{"robot": "weeder-01", "camera": "front", "fps": 5, "width": 640}]}
    assert (process.asked[0][:2], json.loads(process.asked[0][2])) == (("PUT", "/recording"), wish)


async def test_only_cameras_with_viewers_are_looked_at_and_nobody_is_asked_without_a_page() -> None:
    process = Process(200, {"cameras": [{"robot": "a", "camera": "x", "viewers": 2}, {"robot": "b", "camera": "y"}]})
    assert await CameraCalls(process).watched() == [("a", "x")]
    assert await CameraCalls(process, lambda: False).watched() == []
    assert len(process.asked) == 1


@pytest.mark.parametrize(
    ("status", "body", "code"),
    [
        (404, {"code": "unknown_camera", "text": "There is no such camera."}, "unknown_camera"),
        (404, b"", "no_picture"),
        (409, {"code": "nothing_kept"}, "nothing_kept"),
        (507, {"code": "disk_full"}, "disk_full"),
    ],
)
async def test_a_refusal_is_told_with_its_code_and_a_sentence(status: int, body: Any, code: str) -> None:
    with pytest.raises(NoPicture) as refused:
        await CameraCalls(Process(status, body)).clip("weeder-01", "front", 0, 1, PATH)
    assert refused.value.code == code
    assert refused.value.text.endswith(".")


@pytest.mark.parametrize("process", [Process(500, b"x"), Process(200, b"no time"), Process(503, {})])
async def test_an_answer_that_is_none_means_that_the_process_is_away(process: Process) -> None:
    with pytest.raises(CamerasAway):
        await CameraCalls(process).still("weeder-01", "front", None)


@pytest.mark.parametrize("body", [b"", b"[]", {"from": 1}, {**WRITTEN, "from": "x"}, {**WRITTEN, "width_px": None}])
async def test_a_clip_that_is_told_of_in_part_is_none(body: Any) -> None:
    with pytest.raises(CamerasAway):
        await CameraCalls(Process(201, body)).clip("weeder-01", "front", 0, 1, PATH)
