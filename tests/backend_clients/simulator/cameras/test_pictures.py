"""What a picture shows is where the world has it."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from backend_clients.simulator.cameras import time_code
from backend_clients.simulator.cameras.composer import Canvas
from backend_clients.simulator.cameras.crops import crop_of, outcome_of, plants_near, weeds_near
from backend_clients.simulator.cameras.depth import distances
from backend_clients.simulator.cameras.eye import Eye
from backend_clients.simulator.cameras.mounts import MOUNTS
from backend_clients.simulator.cameras.observer import Observer
from backend_clients.simulator.cameras.painter import Painter
from backend_clients.simulator.cameras.scene import Ground, Rows, Scene, Thing
from backend_clients.simulator.cameras.scenery import Scenery
from backend_clients.simulator.cameras.sky import light_at
from backend_clients.simulator.cameras.stage import Stage
from backend_clients.simulator.cameras.textures import is_made
from backend_clients.simulator.families import FAMILIES
from tests.backend_clients.simulator.cameras.field import (
    FIELD,
    MIDNIGHT,
    NOON,
    ROWS,
    ahead,
    drawn,
    look,
    opened,
    person,
)
from tests.backend_clients.simulator.rig import Rig

WIDE, HIGH = 640, 480


def front_eye() -> Eye:
    return MOUNTS["weeder", "front"].eye(look(), WIDE, HIGH)


def greenness(pixels: np.ndarray, u: float, v: float) -> float:
    part = pixels[round(v) - 1 : round(v) + 2, round(u) - 1 : round(u) + 2].astype(float)
    return float((part[:, :, 1] - part[:, :, 0]).mean())


def test_a_known_plant_is_at_the_pixel_where_it_must_be_and_between_the_rows_is_soil() -> None:
    pixels, _ = drawn(look())
    eye, high = front_eye(), crop_of(ROWS.crop).high_m
    plants = plants_near(ROWS, *ahead(3.4), 0.9)
    u, v, _ = eye.project(np.column_stack((plants[:, :2], np.full(len(plants), high * 0.7))))
    is_in = (u > 10) & (u < WIDE - 10) & (v > 60) & (v < HIGH - 40)
    assert is_in.sum() >= 10
    green = [greenness(pixels, a, b) for a, b in zip(u[is_in], v[is_in], strict=True)]
    bare = [ahead(m, 0.25) for m in np.linspace(2.8, 4.0, 9)]
    u, v, _ = eye.project(np.array([(x, y, 0.0) for x, y in bare]))
    brown = [greenness(pixels, a, b) for a, b in zip(u, v, strict=True)]
    assert np.median(green) > 15
    assert np.median(brown) < -5


def test_plants_move_past_as_the_machine_drives_and_stay_where_they_stand() -> None:
    x, y = ahead(1.0)
    before, after = drawn(look())[0], drawn(look(x_m=x, y_m=y))[0]
    near, far = MOUNTS["weeder", "front"].eye(look(x_m=x, y_m=y), WIDE, HIGH), front_eye()
    plants = plants_near(ROWS, *ahead(5.2), 0.6)
    points = np.column_stack((plants[:, :2], np.full(len(plants), 0.1)))
    for eye, pixels in ((far, before), (near, after)):
        u, v, _ = eye.project(points)
        assert np.median([greenness(pixels, a, b) for a, b in zip(u, v, strict=True)]) > 12
    assert np.abs(before.astype(int) - after.astype(int)).mean() > 5


@pytest.mark.parametrize("left", [-1.2, 0.0, 1.2])
def test_somebody_ahead_is_seen_and_found_in_the_column_where_they_stand(left: float) -> None:
    pixels, boxes = drawn(look(things=[person(5.0, left)]))
    [box] = [one for one in boxes if one.kind == "person"]
    u, _, _ = front_eye().project(np.array([(*ahead(5.0, left), 1.2)]))
    middle = (box.x + box.w / 2) * WIDE
    assert middle == pytest.approx(float(u[0]), abs=3)
    assert box.hit is None
    vest = pixels[round((box.y + 0.28 * box.h) * HIGH), round(middle)]
    assert vest[0] > 180
    assert vest[0] > vest[2] + 90
    empty, none = drawn(look())
    assert not [one for one in none if one.kind == "person"]
    assert (empty[round((box.y + 0.28 * box.h) * HIGH), round(middle)] != vest).any()


@pytest.mark.slow
@given(st.integers(0, 2**24 - 1), st.sampled_from((96, 320, 640, 1024)))
def test_the_time_code_is_read_back(bits: int, wide: int) -> None:
    pixels = np.full((wide * 3 // 4, wide), 0xFF808080, dtype=np.uint32)
    time_code.burn(pixels, bits + (3 << 24))
    colours = pixels.view(np.uint8).reshape(*pixels.shape, 4)[:, :, :3]
    assert time_code.read(colours) == bits


@pytest.mark.parametrize(("camera", "width"), [("front", 640), ("tof", 352), ("front", 2048), ("front", 320)])
def test_the_time_code_survives_the_jpeg(camera: str, width: int) -> None:
    pixels, _ = drawn(look(camera, width=width, wall_ms=NOON + 4321))
    assert time_code.read(pixels) == (NOON + 4321) & 0xFFFFFF


def test_a_picture_without_a_code_says_nothing() -> None:
    assert time_code.read(np.full((480, 640, 3), 128, dtype=np.uint8)) is None


def test_the_laser_hits_weeds_behind_it_misses_a_few_and_has_not_been_at_those_ahead() -> None:
    row = [(*ahead(-200.0), *ahead(0.0))]
    weeds = weeds_near(ROWS, *ahead(-100.0), 90.0)
    outcome = outcome_of(weeds, row)
    swath = np.abs(weeds[:, 1] * math.cos(math.radians(70)) - weeds[:, 0] * math.sin(math.radians(70))) < 0.7
    assert set(outcome[swath]) == {0, 1}
    assert 0.9 < (outcome[swath] == 1).mean() < 0.99
    assert (outcome_of(weeds_near(ROWS, *ahead(5.0), 3.0), row) == -1).all()


def test_weeds_are_found_in_the_tool_view_and_told_hit_only_where_the_tool_was() -> None:
    treated = [(*ahead(-30.0), *ahead(0.0))]
    found = [box for k in range(12) for box in drawn(look("tool", x_m=ahead(k * 2)[0], y_m=ahead(k * 2)[1]))[1]]
    assert found
    assert {box.hit for box in found if box.kind == "weed"} == {None}
    rear = drawn(look("rear", treated=treated))[1]
    assert True in {box.hit for box in rear if box.kind == "weed"}


def test_the_ground_before_the_distance_camera_is_as_far_as_geometry_says() -> None:
    wanted = look("tof", width=352, things=[person(4.0)])
    mount = MOUNTS["weeder", "tof"]
    eye = mount.eye(wanted, 352, 264)
    canvas = Canvas(wanted, mount, eye, light_at(NOON, 52, 5), Stage(FIELD), np.empty((264, 352), dtype=np.uint32))
    metres = distances(canvas)
    chest = (*ahead(4.0), 1.0)
    u, v, _ = eye.project(np.array([(*ahead(2.6, 0.25), 0.0), chest]))
    ground, body = (float(metres[round(b), round(a)]) for a, b in zip(u, v, strict=True))
    assert ground == pytest.approx(math.dist((eye.x_m, eye.y_m, eye.z_m), (*ahead(2.6, 0.25), 0.0)), abs=0.12)
    assert body == pytest.approx(math.dist((eye.x_m, eye.y_m, eye.z_m), chest), rel=0.06)


def test_night_is_dark_and_the_lamp_lights_the_ground_ahead() -> None:
    day = drawn(look())[0][60:-40].mean()
    off = drawn(look(wall_ms=MIDNIGHT, lamp=False))[0][60:-40].mean()
    lit = drawn(look(wall_ms=MIDNIGHT))[0][60:-40].mean()
    assert off < day / 6
    assert lit > off * 3


def test_a_lamp_by_day_lightens_the_ground_ahead_and_nothing_else() -> None:
    off, lit = drawn(look())[0].astype(int), drawn(look(lamp=True))[0].astype(int)
    assert lit[300:440, 200:440].mean() > off[300:440, 200:440].mean() * 1.15
    assert np.abs(lit[20:90] - off[20:90]).mean() < 1, "not the sky"


def test_a_first_picture_does_not_wait_for_plants_and_the_next_has_them_as_fine_as_ever() -> None:
    rows = Rows("Carrot", 0.41, ROWS.bearing_rad, ROWS.anchor)  # a crop nobody else here draws
    scene = Scene("hasty", FIELD.lat_deg, FIELD.lon_deg, [Ground("field", FIELD.grounds[0].ring, rows)])
    painter = Painter()
    painter.keep(scene)
    wanted = msgspec.structs.replace(look(), scene="hasty", is_hasty=True)
    first = painter.draw(1, wanted)
    assert not is_made(rows)
    assert time_code.read(opened(first.jpeg)) == wanted.wall_ms & 0xFFFFFF
    painter.catch_up()
    assert is_made(rows)
    usual = msgspec.structs.replace(wanted, is_hasty=False)
    assert painter.draw(2, wanted).jpeg == painter.draw(3, usual).jpeg != first.jpeg


def test_the_infrared_camera_sees_leaves_bright_by_night() -> None:
    pixels, _ = drawn(look("side", wall_ms=MIDNIGHT))
    below = pixels[280:440].astype(int)
    assert (below[:, :, 0] == below[:, :, 1]).mean() > 0.9
    assert np.percentile(below, 97) > 3 * np.percentile(below, 20)


def test_zoom_pan_and_tilt_act_in_the_picture() -> None:
    somebody = [person(8.0)]
    [usual] = [b for b in drawn(look(things=somebody))[1] if b.kind == "person"]
    [large] = [b for b in drawn(look(things=somebody, zoom=2.0))[1] if b.kind == "person"]
    [panned] = [b for b in drawn(look(things=somebody, pan_rad=0.2))[1] if b.kind == "person"]
    [tilted] = [b for b in drawn(look(things=somebody, tilt_rad=-0.2))[1] if b.kind == "person"]
    assert large.w == pytest.approx(2 * usual.w, rel=0.05)
    assert panned.x > usual.x + 0.08  # it looks left, so that they are further right
    assert tilted.y > usual.y + 0.05  # it looks up, so that they are lower


def test_the_uav_sees_the_ground_that_is_below_it() -> None:
    over = Thing("weeder", 6.0, 4.0, 1.0)
    above = look("gimbal", family="uav", width=960, z_m=30.0, tilt_rad=-math.pi / 2, x_m=0.0, y_m=0.0, things=[over])
    pixels, _ = drawn(above)
    eye = MOUNTS["uav", "gimbal"].eye(above, 960, 540)
    u, v, _ = eye.project(np.array([(6.0, 4.0, 1.2)]))
    spot = pixels[round(float(v[0])) - 12 : round(float(v[0])) + 12, round(float(u[0])) - 12 : round(float(u[0])) + 12]
    assert spot.min(axis=2).max() > 200  # its white hood
    assert pixels[100:130, 400:430].min(axis=2).max() < 190


@pytest.mark.parametrize("family", sorted(FAMILIES))
def test_every_camera_of_a_family_has_a_place_and_a_node_that_is_there(family: str) -> None:
    profile = FAMILIES[family]  # type: ignore[index]
    nodes = {node.name for node in profile.nodes}
    joints = {joint.name for joint in profile.joints}
    for camera in profile.cameras:
        mount = MOUNTS[family, camera.id]
        assert mount.node in nodes
        assert camera.kind == mount.kind
        assert camera.fov_deg == mount.fov_deg
        assert camera.has_lamp <= (mount.lamp_m > 0)
        assert {camera.ptz.pan, camera.ptz.tilt} - {None} <= joints if camera.ptz else True


def test_the_sun_is_up_at_noon_and_down_at_midnight() -> None:
    noon, night = light_at(NOON, 51.8, 4.3), light_at(MIDNIGHT, 51.8, 4.3)
    assert math.degrees(noon.height_rad) == pytest.approx(58, abs=2)  # 20 May
    assert noon.day == 1.0
    assert night.is_dark
    assert math.degrees(night.height_rad) < -10


def test_a_demo_sees_a_summer_morning_at_any_hour_and_still_burns_in_the_true_time() -> None:
    rig = Rig()
    camera = rig.robot.config.profile.cameras[0]
    seen, _ = Observer({"weeder-01": rig.robot}, rig.clock, Scenery(), is_always_day=True).take(rig.robot, camera, 320)
    assert seen.sun_ms is not None
    assert light_at(seen.sun_ms, 51.8, rig.robot.config.datum_lon_deg).day == 1.0
    at_night = look("front", wall_ms=MIDNIGHT)
    dark, _ = drawn(at_night)
    bright, _ = drawn(msgspec.structs.replace(at_night, sun_ms=seen.sun_ms))
    assert bright.mean() > 2 * dark.mean()
    assert time_code.read(bright) == MIDNIGHT & 0xFFFFFF
