"""Whatever comes in, a file is read or refused; nothing else happens."""

from __future__ import annotations

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hmi.map_files.errors import BadMapFile
from hmi.map_files.reader import read_map
from tests.hmi.map_files import samples

GOOD = samples.good() | {"raw": json.dumps([{"type": "AgriParcel", "id": "a", "location": 3, "name": []}]).encode()}
LAYER = samples.layer("a", [samples.UTM_SQUARE] * 3, [{"name": "A"}] * 3, 25832)
STARTS = st.sampled_from([b"", b"PK\x03\x04", b"<kml>", b"<gpx>", b'{"type":', b"[", b"\xff\xfe<", b"\xef\xbb\xbf{"])
QUIET = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
WORDS = [
    "type",
    "features",
    "geometry",
    "coordinates",
    "properties",
    "geometries",
    "crs",
    "id",
    "name",
    "kind",
    "location",
]
TYPES = ["Feature", "FeatureCollection", "Point", "Polygon", "MultiPolygon", "LineString", "GeometryCollection",
         "AgriParcel", "AgriFarm", "AgriCrop", "RoadSegment"]  # fmt: skip
json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(WORDS), inner, max_size=4),
    max_leaves=15,
)


def read_or_refuse(data: bytes, name: str = "map") -> None:
    text = "."
    found = 1
    try:
        imported = read_map(data, name)
        found = len(imported.items) + len(imported.skipped)
    except BadMapFile as error:
        text = error.text
    assert found > 0
    assert text.endswith(".")


@given(STARTS, st.binary(max_size=300))
@QUIET
def test_random_bytes(start: bytes, data: bytes) -> None:
    read_or_refuse(start + data)


@pytest.mark.parametrize("name", sorted(GOOD))
@given(data=st.data())
@settings(QUIET, max_examples=15)
def test_good_files_with_bytes_changed(name: str, data: st.DataObject) -> None:
    changed = bytearray(GOOD[name])
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(changed) - 1))
        changed[at] = data.draw(st.integers(0, 255))
    read_or_refuse(bytes(changed[: data.draw(st.integers(1, len(changed)))]), name)


@given(suffix=st.sampled_from(sorted(LAYER)), data=st.data())
@QUIET
@pytest.mark.slow
def test_shapefiles_with_bytes_changed_within_a_whole_zip(suffix: str, data: st.DataObject) -> None:
    changed = bytearray(LAYER[suffix])
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, len(changed) - 1))
        changed[at] = data.draw(st.sampled_from([0, 1, 2, 127, 128, 255]) | st.integers(0, 255))
    cut = data.draw(st.just(len(changed)) | st.integers(0, len(changed)))
    read_or_refuse(samples.packed(LAYER | {suffix: bytes(changed[:cut])}))


@given(st.sampled_from(TYPES), st.dictionaries(st.sampled_from(WORDS), json_values, max_size=5))
@QUIET
def test_json_of_the_right_words_in_the_wrong_places(kind: str, members: dict[str, object]) -> None:
    value = {**members, "type": kind}
    read_or_refuse(json.dumps(value).encode())
    read_or_refuse(json.dumps([value]).encode())
    feature = {"type": "Feature", "geometry": value, "properties": members, "id": members.get("id")}
    read_or_refuse(json.dumps({"type": "FeatureCollection", "features": [feature, value]}).encode())
