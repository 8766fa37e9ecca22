"""Forward kinematics: own models move as their machines do, limits hold, nonsense moves nothing."""

from __future__ import annotations

import math

import pytest

from hmi.twin.kinematics import Kinematics, Place
from hmi.twin.library import FAMILIES, OWN, own_model
from hmi.twin.machine import Form
from hmi.twin.mesh_files import MeshFolder
from hmi.twin.model import Model, ModelJoint
from hmi.twin.rotation import yaw
from hmi.twin.skin import skin_of


def arm(kind: str = "revolute", lower: float | None = -1.0, upper: float | None = 1.0) -> Kinematics:
    """Return a base with one joint, 1 m ahead, about z."""
    joint = ModelJoint("j", kind, "base", "arm", xyz=(1.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), lower=lower, upper=upper)
    return Kinematics(Model("m", "base", {"base": (), "arm": ()}, (joint,)))


def test_a_joint_turns_by_its_value_and_not_beyond_its_limit() -> None:
    assert dict(arm().places({"j": 0.5}))["arm"].wxyz == pytest.approx(yaw(0.5))
    assert dict(arm().places({"j": 9.0}))["arm"].wxyz == pytest.approx(yaw(1.0))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_value_that_is_no_number_leaves_the_joint_at_rest(value: float) -> None:
    assert dict(arm().places({"j": value}))["arm"].wxyz == pytest.approx(yaw(0.0))


def test_a_prismatic_joint_moves_along_its_axis() -> None:
    place = dict(arm("prismatic", 0.0, 2.0).places({"j": 1.5}))["arm"]
    assert place.xyz == pytest.approx((1.0, 0.0, 1.5))


def planter() -> Form:
    """Return the planter."""
    model = own_model("planter")
    return Form.of(model, skin_of(model, MeshFolder(OWN).read))


@pytest.mark.parametrize(
    "pose",
    [
        {"slew": 0.0, "boom": 1.1, "stick": -2.35, "telescope": 0.0, "rotator": 0.0},
        {"slew": 0.3, "boom": 0.4, "stick": -1.1, "telescope": 0.7, "rotator": 0.2},
        {"slew": -1.2, "boom": 0.9, "stick": -1.9, "telescope": 2.0, "rotator": 1.0},
    ],
)
def test_the_tip_of_the_planters_crane_is_where_the_machine_says(pose: dict[str, float]) -> None:
    # pillar 1.8 m behind the reference point, 2.4 m high; boom 3.6 m, stick 2.6 m; the head hangs plumb, 1.5 m long
    boom, stick = pose["boom"], pose["boom"] + pose["stick"]
    far = 3.6 * math.cos(boom) + (2.6 + pose["telescope"]) * math.cos(stick)
    high = 2.4 + 3.6 * math.sin(boom) + (2.6 + pose["telescope"]) * math.sin(stick) - 1.5
    said = (-1.8 - far * math.cos(pose["slew"]), -far * math.sin(pose["slew"]), high)
    assert planter().head(Place((0.0, 0.0, 0.0)), pose) == pytest.approx(said, abs=1e-3)


def test_the_tip_turns_with_the_body() -> None:
    pose = {"slew": 0.0, "boom": 0.4, "stick": -1.1, "telescope": 0.7, "rotator": 0.0}
    at_rest = planter().head(Place((0.0, 0.0, 0.0)), pose)
    turned = planter().head(Place((10.0, 5.0, 0.0), yaw(math.pi / 2)), pose)
    assert at_rest is not None
    assert turned == pytest.approx((10.0 - at_rest[1], 5.0 + at_rest[0], at_rest[2]), abs=1e-6)


@pytest.mark.parametrize(
    ("family", "size"), [("weeder", (2.6, 1.7, 1.63)), ("planter", (6.4, 2.6, 3.2)), ("uav", (0.96, 0.96, 0.4))]
)
def test_own_models_have_the_size_of_their_machines(family: str, size: tuple[float, float, float]) -> None:
    model = own_model(family)
    corners = skin_of(model, MeshFolder(OWN).read).links[model.root].corners
    found = corners.max(axis=0) - corners.min(axis=0)
    assert list(found) == pytest.approx(size, rel=0.12)


def test_every_family_has_a_model_whose_joints_are_named() -> None:
    joints = {family: {joint.name for joint in own_model(family).joints if joint.moves} for family in FAMILIES}
    assert {"slew", "boom", "stick", "telescope", "rotator"} <= joints["planter"]
    assert {"pan", "tilt"} <= joints["weeder"]
    assert "tilt" in joints["uav"]
