"""Files that mean harm are refused, and nothing of them is fetched, unpacked or believed."""

from __future__ import annotations

import io
import zipfile

import pytest

from hmi.map_files.errors import BadMapFile
from hmi.map_files.reader import read_map
from tests.hmi.map_files import samples

KML = samples.file("farm.kml")


def refused(data: bytes, name: str = "map.kmz") -> BadMapFile:
    with pytest.raises(BadMapFile) as caught:
        read_map(data, name)
    assert caught.value.text.endswith(".")
    return caught.value


@pytest.mark.parametrize(
    "head",
    [
        '<!DOCTYPE kml [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE kml [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>',
        '<!DOCTYPE kml SYSTEM "http://example.com/kml.dtd">',
        "<!DOCTYPE kml>",
        '<!DOCTYPE kml [<!ENTITY % p SYSTEM "http://example.com/p"> %p;]>',
    ],
)
@pytest.mark.parametrize("root", ["kml", "gpx", "ISO11783_TaskData"])
def test_document_types_and_entities_are_refused(head: str, root: str) -> None:
    assert refused(f"<?xml version='1.0'?>{head}<{root}>&x;</{root}>".encode(), "a.kml").code == "unsafe_xml"


def test_xml_that_is_nested_without_end_is_refused() -> None:
    assert refused(b"<kml>" + b"<Folder>" * 5000 + b"</Folder>" * 5000 + b"</kml>").code == "broken_xml"


@pytest.mark.parametrize(
    "path", ["../doc.kml", "/doc.kml", "a/../../doc.kml", "C:/doc.kml", "..\\doc.kml", "\\doc.kml"]
)
def test_paths_that_lead_out_of_the_archive_are_refused(path: str) -> None:
    assert refused(samples.packed({path: KML})).code == "unsafe_path"


def test_links_in_an_archive_are_refused() -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        info = zipfile.ZipInfo("doc.kml")
        info.create_system, info.external_attr = 3, 0o120777 << 16
        archive.writestr(info, "/etc/passwd")
    assert refused(stream.getvalue()).code == "unsafe_path"


@pytest.mark.parametrize("name", ["inner.zip", "inner.kmz", "doc.kml"])
def test_archives_in_archives_are_refused(name: str) -> None:
    assert refused(samples.packed({name: samples.packed({"doc.kml": KML})})).code == "nested_archive"


def test_what_packs_too_well_is_refused() -> None:
    assert refused(samples.packed({"doc.kml": bytes(20_000_000)})).code == "archive_bomb"


def test_what_says_it_is_huge_is_refused_before_it_is_unpacked() -> None:
    data = bytearray(samples.packed({"doc.kml": KML}))
    at = data.rindex(b"PK\x01\x02") + 24
    data[at : at + 4] = (300_000_000).to_bytes(4, "little")
    assert refused(bytes(data)).code == "archive_bomb"


def test_too_many_files_are_refused() -> None:
    assert refused(samples.packed({f"{n}.txt": b"" for n in range(2001)})).code == "too_many_files"


def test_a_locked_archive_says_so() -> None:
    data = bytearray(samples.packed({"doc.kml": KML}))
    for mark, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        data[data.index(mark) + offset] |= 1
    assert refused(bytes(data)).code == "locked_archive"


def test_unusual_packing_is_refused() -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("doc.kml", KML)
    assert refused(stream.getvalue()).code == "odd_archive"


def test_a_file_that_is_too_large_is_refused() -> None:
    assert refused(b"{" + bytes(50_000_000)).code == "too_large"


def test_a_cut_archive_is_refused() -> None:
    data = samples.packed({"doc.kml": KML})
    assert refused(data[: len(data) // 2]).code == "damaged_archive"


def test_task_data_reads_no_file_outside_of_its_archive() -> None:
    imported = read_map(samples.file("TASKDATA.XML"), "TASKDATA.XML")
    assert {s.which for s in imported.skipped if s.which.endswith(".XML")} == {"PFD00001.XML", "PFD00002.XML"}
