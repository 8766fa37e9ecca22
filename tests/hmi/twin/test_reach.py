"""How far a crane reaches is found from its model and its limits, and is what the crane itself can do."""

from __future__ import annotations

import itertools
import math

import msgspec
import numpy as np
import pytest

from backend_clients.simulator.crane import BY_NAME, JOINTS, PILLAR_X_M, OutOfReach, pose_for, tip_of
from hmi.twin.library import OWN, own_model
from hmi.twin.machine import Form
from hmi.twin.mesh_files import MeshFolder
from hmi.twin.reach import reach_of
from hmi.twin.skin import skin_of


@pytest.fixture(scope="module")
def planter() -> Form:
    """The planter's own model."""
    model = own_model("planter")
    return Form.of(model, skin_of(model, MeshFolder(OWN).read))


def soft_span(name: str) -> tuple[float, float]:
    """Return the soft limits of a joint."""
    joint = BY_NAME[name]
    assert joint.soft_lower is not None
    assert joint.soft_upper is not None
    return joint.soft_lower, joint.soft_upper


def test_the_arc_is_the_furthest_that_any_posture_of_the_crane_comes(planter: Form) -> None:
    reach = reach_of(planter, list(JOINTS))
    assert reach is not None
    spans = [np.linspace(*soft_span(name), 13) for name in ("boom", "stick", "telescope")]
    furthest = 0.0
    for boom, stick, telescope in itertools.product(*spans):
        x, y, z = tip_of({"slew": 0.0, "boom": boom, "stick": stick, "telescope": telescope})
        if 0.0 <= z <= 1.6:
            furthest = max(furthest, math.dist((x, y), (PILLAR_X_M, 0.0)))
    assert reach.radius_m == pytest.approx(furthest, rel=0.03)
    assert (reach.x_m, reach.y_m) == pytest.approx((PILLAR_X_M, 0.0), abs=0.01)
    assert math.cos(reach.from_rad + soft_span("slew")[1]) == pytest.approx(-1.0, abs=0.01)  # slew 0 points backwards


def test_no_order_reaches_beyond_the_arc(planter: Form) -> None:
    reach = reach_of(planter, list(JOINTS))
    assert reach is not None
    for z_m in np.linspace(0.0, 1.6, 9):
        with pytest.raises(OutOfReach):
            pose_for((reach.x_m - 1.02 * reach.radius_m, reach.y_m, float(z_m)))


def test_a_tighter_soft_limit_shortens_the_reach(planter: Form) -> None:
    tight = [msgspec.structs.replace(one, soft_upper=1.0) if one.name == "telescope" else one for one in JOINTS]
    whole, short = reach_of(planter, list(JOINTS)), reach_of(planter, tight)
    assert whole is not None
    assert short is not None
    assert 2.0 < whole.radius_m - short.radius_m < 2.6


def test_a_machine_without_an_arm_has_no_reach(planter: Form) -> None:
    assert reach_of(planter, []) is None
    weeder = own_model("weeder")
    assert reach_of(Form.of(weeder, skin_of(weeder, MeshFolder(OWN).read)), list(JOINTS)) is None
