"""A wish as it goes to a planner, and back: what it needs to plan, and no names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, cast

from backend_clients.planner import messages as wire
from hmi.domain.mission_plan import Corner, Geometry, Pattern, PlanWish, Rows, Surroundings, TreatedArea, Treatment

if TYPE_CHECKING:
    from hmi.planning.machine import RobotProfile
    from hmi.planning.projection import LocalFrame

LIMITS = ("length_m", "width_m", "base_to_front_m", "turning_radius_m", "can_pivot", "row_speed_mps", "turn_speed_mps",
          "transit_speed_mps", "accel_mps2", "yaw_rate_radps", "margin_m", "reverse_mps")  # fmt: skip
TOLD = frozenset({
    "parcel", "width_m", "datum_lat_deg", "datum_lon_deg", "angle_rad", "headland_passes", "home", "returns_home",
    "surroundings", "pattern", "corner", "overlap", "treatment",
    "robot", "row_speed_mps", "plant_spacing_m",  # as the machine's own limits
    "mission_id", "name", "robot_id", "field_name", "revision",  # stay here
})  # fmt: skip
WORDS = {
    "rows": "rows along lines of the map or the field's edge",
    "row_lines": "rows along lines of the map or the field's edge",
    "row_spacing_m": "rows along lines of the map or the field's edge",
}
Features = Sequence[tuple[Geometry, float]]


def form_of(wish: PlanWish) -> wire.Wish:
    """Return what is sent; loads the planner's geometry.

    Raises:
        PlanRefused: the wish asks for what its robot cannot.
        ValueError: the wish does not fit the format.
    """
    from hmi.planning.mission import job_of, machine_of
    from hmi.planning.projection import LocalFrame

    _only_known(wish)
    machine = machine_of(wish)
    job = job_of(wish)
    frame = LocalFrame(wish.datum_lat_deg, wish.datum_lon_deg)
    return wire.Wish(
        datum=wire.Datum(lat_deg=wish.datum_lat_deg, lon_deg=wish.datum_lon_deg),
        field=_rings(wish.parcel),
        machine=_machine(machine),
        width_m=wish.width_m,
        overlap=wish.overlap,
        angle_rad=wish.angle_rad,
        headland_passes=job.headland_passes,
        pattern=wish.pattern.value,
        corner=None if wish.corner is None else wish.corner.value,
        home=wish.home,
        returns_home=wish.returns_home,
        obstacles=_closed(wish.surroundings, frame, machine),
        ways=_grounds(wish.surroundings.ways),
        treatment=wire.Treatment(
            areas=[wire.DoseArea(geometry=_plain(one.geometry), dose=one.dose) for one in wish.treatment.areas],
            rest_dose=wish.treatment.rest_dose,
            lead_in_m=job.doses.lead_in_m,
            lead_out_m=job.doses.lead_out_m,
        ),
    )


def _machine(machine: RobotProfile) -> wire.Machine:
    limits = {name: getattr(machine, name) for name in LIMITS}
    # on the ground it says nothing of it: a service of an older edition takes such a wish as before
    return wire.Machine(**limits, family="uav" if machine.flies else "")


def _only_known(wish: PlanWish) -> None:
    """A wish for something the format has no word for is not sent: the service would plan something else."""
    plain = replace(wish, rows=None) if wish.rows is Rows.BEST_ANGLE else wish  # what a planner does without an angle
    if wish.rows is not Rows.RECORDED_ROWS:  # nearly every field has it, and it bears on recorded rows alone
        plain = replace(plain, row_spacing_m=None)
    unsaid = [one.name for one in fields(wish) if one.name not in TOLD and getattr(plain, one.name) != one.default]
    if unsaid:
        words = dict.fromkeys(WORDS.get(name, name.replace("_", " ")) for name in unsaid)
        raise ValueError(f"planner services know nothing of {', '.join(words)}")


def wish_of(form: wire.Wish) -> tuple[PlanWish, RobotProfile]:
    """Return the wish and the machine of a form; raises ``PlanRefused`` for a machine that cannot be."""
    from hmi.planning.machine import RobotProfile

    given = form.treatment
    wish = PlanWish(
        mission_id="plan",
        name="Plan",
        robot_id="robot",
        field_name="Field",
        parcel={"type": "Polygon", "coordinates": [[list(place) for place in ring] for ring in form.field]},
        width_m=form.width_m,
        datum_lat_deg=form.datum.lat_deg,
        datum_lon_deg=form.datum.lon_deg,
        angle_rad=form.angle_rad,
        headland_passes=form.headland_passes,
        home=form.home,
        returns_home=form.returns_home,
        surroundings=Surroundings(
            tuple((one.geometry, one.width_m) for one in form.obstacles),
            tuple((one.geometry, one.width_m) for one in form.ways),
        ),
        pattern=Pattern(form.pattern),
        corner=None if form.corner is None else Corner(form.corner),
        overlap=form.overlap,
        treatment=Treatment(
            tuple(TreatedArea(one.geometry, one.dose) for one in given.areas),
            given.rest_dose,
            given.lead_in_m,
            given.lead_out_m,
        ),
    )
    flies = form.machine.family == "uav"
    return wish, RobotProfile(**{name: getattr(form.machine, name) for name in LIMITS}, flies=flies)


def _rings(geometry: Geometry) -> Any:
    rings = geometry["coordinates"] if geometry["type"] == "Polygon" else geometry["coordinates"][0]
    return [[(float(place[0]), float(place[1])) for place in ring] for ring in rings]


def _grounds(features: Features) -> list[wire.Ground]:
    return [wire.Ground(geometry=_plain(geometry), width_m=width_m) for geometry, width_m in features]


def _closed(around: Surroundings, frame: LocalFrame, machine: RobotProfile) -> list[wire.Ground]:
    """Return obstacles: as on the map, but water, hedges and trees with the gaps that roads make in them.

    The format has no word for the clearance that a machine keeps: it is told as a part of them.
    """
    import shapely

    from hmi.planning.surroundings import closed_areas, crossed_areas

    areas = closed_areas(around, frame, machine) if machine.clearance_m else crossed_areas(around, frame)
    degrees = (shapely.transform(area, frame.to_lon_lat) for area in areas)
    made = [wire.Ground(geometry=_plain(shapely.geometry.mapping(area)), width_m=0.0) for area in degrees]
    return made if machine.clearance_m else [*_grounds(around.obstacles), *made]


def _plain(geometry: Geometry) -> dict[str, object]:
    """Return shape and coordinates alone: whatever else stands on a feature stays here."""
    return {"type": geometry["type"], "coordinates": cast("object", geometry["coordinates"])}
