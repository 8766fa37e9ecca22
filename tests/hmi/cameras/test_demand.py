"""What is asked of a camera is the least that satisfies everybody who looks."""

from __future__ import annotations

from hmi.cameras.demand import Way, Wish, plan_of, step_of
from hmi.cameras.picture_wire import JpegWish
from hmi.domain.camera import CameraInfo

LARGE = CameraInfo("front", "Front", 2048, 1536, fps=4.0)
SMALL = CameraInfo("rear", "Rear", 640, 480)


def test_a_tile_asks_for_a_small_picture_twice_a_second() -> None:
    plan = plan_of([Wish(Way.JPEG, 300, 2.0)], LARGE, 1280)
    assert (plan.width, plan.fps, plan.jpegs) == (320, 2.0, (JpegWish(320, 2.0),))
    assert not plan.has_h264


def test_video_of_a_large_camera_is_pulled_as_small_as_it_is_encoded() -> None:
    plan = plan_of([Wish(Way.H264)], LARGE, 1280)
    assert (plan.width, plan.fps, plan.has_h264, plan.jpegs) == (1280, 4.0, True, ())


def test_one_who_wants_everything_gets_it_and_the_tiles_keep_theirs() -> None:
    plan = plan_of([Wish(Way.JPEG, 0, 15.0), Wish(Way.JPEG, 160, 1.0), Wish(Way.JPEG, 150, 2.0)], LARGE, 1280)
    assert plan.width == 0
    assert plan.jpegs == (JpegWish(0, 15.0), JpegWish(160, 2.0))


def test_a_wish_at_or_above_the_cameras_own_width_means_the_picture_as_it_is() -> None:
    assert [step_of(width, SMALL) for width in (0, 640, 900, 639, 100)] == [0, 0, 0, 0, 160]


def test_video_is_encoded_no_wider_than_the_widest_that_looks_and_never_wider_than_allowed() -> None:
    wishes = [Wish(Way.H264, 640), Wish(Way.H264, 312), Wish(Way.JPEG, 900, 2.0)]
    plan = plan_of(wishes, LARGE, 1280)
    assert (plan.video_width, plan.width) == (640, 960)
    assert plan_of([*wishes, Wish(Way.H264)], LARGE, 1280).video_width == 1280
    assert plan_of([Wish(Way.H264, 1900)], LARGE, 800).video_width == 800
