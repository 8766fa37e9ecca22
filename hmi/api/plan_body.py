"""What people send to have a mission planned."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from hmi.api.body import Body, Id
from hmi.commands.plan_wish import AreaOrder, PlanOrder
from hmi.domain.mission_plan import Corner, Pattern, Rows, StartPlace

MOST_AREAS = 200
LEAST_WIDTH_M, MOST_WIDTH_M = 0.05, 50.0  # what the planner takes; it is not loaded here
Dose = Annotated[float, Field(ge=0, le=2, description="times the usual dose; 0 is off")]
Metres = Annotated[float | None, Field(ge=0, le=10)]


class AreaBody(Body):
    """Ground with a dose of its own: a feature of the map, or a GeoJSON polygon."""

    dose: Dose
    feature_id: Id | None = None
    geometry: dict[str, Any] | None = None

    @model_validator(mode="after")
    def _one_of_both(self) -> AreaBody:
        if (self.feature_id is None) == (self.geometry is None):
            raise ValueError("give either feature_id or geometry")
        return self


class PlanChoices(Body):
    """How to plan, without where and for whom; what is left out is chosen."""

    width_m: Annotated[float, Field(description="working width; the rows are that far apart, less the overlap")]
    name: Annotated[str, Field(max_length=80)] = ""
    row_bearing_deg: Annotated[float | None, Field(ge=-360, le=360, description="clockwise from north")] = None
    rows: Annotated[Rows | None, Field(strict=False, description="what the rows run along")] = None
    headland_passes: Annotated[int | None, Field(ge=0, le=50)] = None
    home_id: Id | None = None
    starts_at: Annotated[StartPlace, Field(strict=False, description="field: no way from home and back")] = (
        StartPlace.HOME
    )
    returns_home: bool = True
    is_supervised: bool = True
    pattern: Annotated[Pattern, Field(strict=False)] = Pattern.SHORTEST
    start_corner: Annotated[Corner | None, Field(strict=False)] = None
    overlap: Annotated[float, Field(ge=0, le=0.5, description="share of the width worked twice")] = 0.0
    row_speed_mps: Annotated[float | None, Field(gt=0, le=20)] = None
    plant_spacing_m: Annotated[float | None, Field(ge=0.05, le=100, description="planters, along the row")] = None
    treatments: Annotated[list[AreaBody], Field(max_length=MOST_AREAS, default_factory=list)]
    rest_dose: Dose = 1.0
    lead_in_m: Metres = None
    lead_out_m: Metres = None


class PlanBody(PlanChoices):
    """What to plan; what is left out is chosen."""

    field_id: Id
    robot_id: Id
    draft_id: Annotated[Id | None, Field(description="the draft that this becomes, for /missions/plan")] = None
    draft_revision: Annotated[int, Field(ge=0)] = 0


class DraftWish(PlanChoices):
    """What was chosen so far for a mission that is not planned yet."""

    width_m: Annotated[float | None, Field(gt=0, le=MOST_WIDTH_M)] = None  # type: ignore[assignment]
    field_id: Id | None = None
    robot_id: Id | None = None


class TemplateWish(PlanChoices):
    """Choices to plan with again, for any field and robot or for these."""

    width_m: Annotated[float, Field(ge=LEAST_WIDTH_M, le=MOST_WIDTH_M)]
    field_id: Id | None = None
    robot_id: Id | None = None


def order_of(body: PlanBody) -> PlanOrder:
    """Return the order a body stands for."""
    given = {key: value for key, value in body if key not in ("name", "treatments", "draft_id", "draft_revision")}
    areas = tuple(AreaOrder(one.dose, one.feature_id, one.geometry) for one in body.treatments)
    return PlanOrder(**given, name=" ".join(body.name.split()), treatments=areas)
