"""Zipped shapefiles as they come from offices and machines."""

from __future__ import annotations

import pytest
from pyproj import CRS, Transformer

from hmi.map_files import coordinate_system
from hmi.map_files.errors import BadMapFile
from hmi.map_files.reader import read_map
from tests.hmi.map_files.samples import SQUARE, UTM_SQUARE, layer, packed

DEGREES = [ring[::-1] for ring in SQUARE]


def test_a_layer_is_moved_from_the_system_of_its_prj_file() -> None:
    imported = read_map(packed(layer("felder", [UTM_SQUARE], [{"Schlag": "A", "Gewas": "ui"}], 25832)), "felder.zip")
    (item,) = imported.items
    assert (item.name, item.kind, item.properties) == ("A", "parcel", {"crop": "ui"})
    assert item.geometry["coordinates"][0][0] == pytest.approx([9.0, 52.35], abs=1e-3)
    assert imported.crs == "ETRS89 / UTM zone 32N (EPSG:25832)"


BESSEL = (
    'PROJCS["Gauss_3",GEOGCS["GCS_Bessel_1841",DATUM["D_Bessel_1841",SPHEROID["Bessel_1841",6377397.155,299.1528128]],'
    'PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",9.0],'
    'PARAMETER["Scale_Factor",1.0],PARAMETER["Latitude_Of_Origin",0.0],UNIT["Meter",1.0]]'
)


def test_a_system_of_which_nobody_knows_how_it_lies_on_the_earth_is_said() -> None:
    files = layer("felder", [UTM_SQUARE], [{"name": "A"}]) | {"felder.prj": BESSEL.encode()}
    (item,) = read_map(packed(files), "felder.zip").items
    assert item.problems == (
        "How Gauss_3 lies on the earth is not known: positions may be off by 200 m. Check them on the field.",
    )


def test_a_system_that_is_used_where_it_does_not_hold_is_said() -> None:
    east, north = Transformer.from_crs(4326, 27700, always_xy=True).transform(5.66, 51.97)
    ring = [[east, north], [east, north + 200], [east + 300, north + 200], [east + 300, north], [east, north]]
    (item,) = read_map(packed(layer("fields", [[ring]], [{"name": "A"}], 27700)), "fields.zip").items
    assert "may be off by 200 m" in item.problems[0]


def test_a_datum_within_decimetres_of_wgs84_is_no_unknown_one() -> None:
    china = coordinate_system.from_wkt(CRS.from_epsg(4490).to_wkt("WKT1_ESRI"))
    assert china.to_wgs84([110.0], [35.0]) == ([110.0], [35.0], coordinate_system.NOTABLE_ERROR_M)


def test_parameters_that_the_file_brings_along_are_believed() -> None:
    wkt = BESSEL.replace(",299.1528128]]", ",299.1528128],TOWGS84[598.1,73.7,418.2,0.202,0.045,-2.455,6.7]]")
    files = layer("felder", [UTM_SQUARE], [{"name": "A"}]) | {"felder.prj": wkt.encode()}
    assert read_map(packed(files), "felder.zip").items[0].problems == ()


def test_several_layers_each_have_their_own_system_and_kind() -> None:
    files = layer("sub/fields", [UTM_SQUARE], [{"name": "A"}], 25832)
    files |= layer("sub/buildings", [DEGREES], [{"name": "B"}], 4326)
    imported = read_map(packed(files), "all.zip")
    assert {(item.name, item.kind) for item in imported.items} == {("A", "parcel"), ("B", "building")}


def test_degrees_without_a_prj_file_are_assumed_to_be_wgs84() -> None:
    (item,) = read_map(packed(layer("a", [DEGREES], [{"name": "A"}])), "a.zip").items
    assert item.problems[0].startswith("The file does not name its coordinate system")


def test_metres_without_a_prj_file_are_refused() -> None:
    with pytest.raises(BadMapFile, match=r"add the \.prj file"):
        read_map(packed(layer("a", [UTM_SQUARE], [{"name": "A"}])), "a.zip")


def test_a_layer_without_a_coordinate_system_does_not_take_the_other_along() -> None:
    files = layer("a", [DEGREES], [{"name": "A"}], 4326) | layer("b", [UTM_SQUARE], [{"name": "B"}])
    imported = read_map(packed(files), "a.zip")
    assert [item.name for item in imported.items] == ["A"]
    assert [skipped.which for skipped in imported.skipped] == ["b"]


def test_a_prj_file_that_is_not_understood_is_refused() -> None:
    files = layer("a", [UTM_SQUARE], [{"name": "A"}]) | {"a.prj": b"PROJCS[what]"}
    with pytest.raises(BadMapFile, match="not understood"):
        read_map(packed(files), "a.zip")


def test_a_null_shape_is_skipped_and_the_others_stay() -> None:
    imported = read_map(packed(layer("a", [None, DEGREES], [{"name": "A"}, {"name": "B"}], 4326)), "a.zip")
    assert [item.name for item in imported.items] == ["B"]
    assert [skipped.which for skipped in imported.skipped] == ["a: shape 1"]


@pytest.mark.parametrize(
    ("encoding", "cpg"), [("cp1252", None), ("utf-8", None), ("cp1252", b"ANSI 1252"), ("utf-8", b"UTF-8")]
)
def test_umlauts_survive(encoding: str, cpg: bytes | None) -> None:
    files = layer("a", [DEGREES], [{"name": "Brühl"}], 4326, encoding)
    imported = read_map(packed(files | ({"a.cpg": cpg} if cpg else {})), "a.zip")
    assert imported.items[0].name == "Brühl"


@pytest.mark.parametrize("missing", ["a.dbf", "a.shx"])
def test_shapes_are_read_without_their_index_or_attributes(missing: str) -> None:
    files = layer("a", [DEGREES], [{"name": "A"}], 4326)
    del files[missing]
    (item,) = read_map(packed(files), "a.zip").items
    assert item.geometry["coordinates"] == SQUARE
    assert any("attributes are missing" in problem for problem in item.problems) == (missing == "a.dbf")


def test_a_layer_that_is_cut_off_does_not_take_the_other_along() -> None:
    files = layer("a", [DEGREES], [{"name": "A"}], 4326) | layer("b", [DEGREES], [{"name": "B"}], 4326)
    files["b.shp"] = files["b.shp"][:150]
    imported = read_map(packed(files), "a.zip")
    assert [item.name for item in imported.items] == ["A"]
    assert imported.skipped


@pytest.mark.parametrize(
    ("name", "encoding", "driver", "cpg"),
    [
        ("Żółta łąka", "cp1250", 0xC8, None),
        ("Поле за лесом", "cp1251", 0xC9, None),
        ("Поле за лесом", "cp1251", 0x00, b"ANSI 1251"),
        ("Großer Acker", "cp850", 0x02, None),
        ("Großer Acker", "cp850", 0x00, b"OEM 850"),
        ("Großer Acker", "cp1252", 0x57, None),
        ("Поле за лесом", "utf-8", 0x57, None),  # as programs write that set no driver
    ],
)
def test_names_are_read_in_the_code_page_of_the_table(name: str, encoding: str, driver: int, cpg: bytes | None) -> None:
    files = layer("a", [DEGREES], [{"name": name}], 4326, encoding, size=254)
    table = files["a.dbf"]
    files["a.dbf"] = table[:29] + bytes([driver]) + table[30:]
    imported = read_map(packed(files | ({"a.cpg": cpg} if cpg else {})), "a.zip")
    assert [item.name for item in imported.items] == [name]


def test_a_letter_that_its_column_cuts_in_two_does_not_spoil_the_others() -> None:
    names = ["Поле за лесом", "Поле у реки", "Жёлтое поле"]
    files = layer("a", [DEGREES] * 3, [{"name": one, "note": "я" * 12} for one in names], 4326, "utf-8")
    files["a.dbf"] = files["a.dbf"].replace("я".encode() * 12, "я".encode() * 11 + b"\xd1 ", 1)
    assert [item.name for item in read_map(packed(files), "a.zip").items] == names
