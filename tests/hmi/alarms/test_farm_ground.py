"""What the map says about where machines may be reaches the fence: every farm, its holes, and the keep-out zones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

from hmi.app.farm_ground import FarmGround
from hmi.ingest.supervision.fence import Ground
from hmi.store.database import Database
from hmi.store.features import Feature, Features


def box(lon: float, lat: float, size_deg: float = 0.002) -> list[list[float]]:
    """Return a closed square ring."""
    far_lon, far_lat = lon + size_deg, lat + size_deg
    return [[lon, lat], [far_lon, lat], [far_lon, far_lat], [lon, far_lat], [lon, lat]]


class Map:
    """The features of a farm and the database they are read from."""

    def __init__(self, *features: Feature) -> None:
        self._features = features

    def all(self, _farm_id: str, kinds: Sequence[str] = ()) -> list[Feature]:
        """See ``Features``."""
        return [one for one in self._features if one.kind in kinds]

    async def run(self, work: Callable[..., Any], *given: Any) -> Any:
        """See ``Database``."""
        return work(*given)


async def ground_of(*features: Feature) -> Ground | None:
    """Return the ground that is read from a map."""
    known = Map(*features)
    ground = FarmGround(cast("Features", known), cast("Database", known), "farm")
    await ground.load()
    return ground.now


def feature(kind: str, name: str, *rings: list[list[float]]) -> Feature:
    """Return a polygon of the map."""
    return Feature(f"{kind}-{name}", "farm", kind, name, {"type": "Polygon", "coordinates": list(rings)})


async def test_every_farm_its_holes_and_the_keep_out_zones_are_read() -> None:
    ground = await ground_of(
        feature("farm", "Home", box(5.0, 52.0), box(5.0002, 52.0002, 0.0002)),
        feature("farm", "East", box(5.01, 52.0)),
        feature("no-go", "Pond", box(5.001, 52.001, 0.0004)),
        feature("no-go", "", box(5.0015, 52.0002, 0.0002)),
        feature("parcel", "Nordfeld", box(5.02, 52.0)),
    )
    assert ground is not None

    def where(lon: float, lat: float) -> str:
        return ground.outside_m(*ground.metres(lat, lon))[1]

    assert [where(5.0006, 52.0006), where(5.011, 52.001)] == ["", ""]
    assert [where(5.0003, 52.0003), where(5.021, 52.001)] == ["outside the farm's edge"] * 2
    assert [where(5.0012, 52.0012), where(5.0016, 52.0003)] == ["inside keep-out zone Pond", "inside a keep-out zone"]


async def test_a_map_without_them_has_no_ground() -> None:
    assert await ground_of(feature("parcel", "Nordfeld", box(5.02, 52.0))) is None
