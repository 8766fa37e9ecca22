"""Uploaded models: only what lies in the zip is read, and every refusal names the link or file."""

from __future__ import annotations

import io
import json
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from hmi.twin.errors import ModelError, UnsafeModel
from hmi.twin.upload import load_kept, read_upload


def robot(mesh: str) -> str:
    """Return a URDF whose arm is this mesh."""
    return (
        '<robot name="own"><link name="base"><visual><geometry><box size="1 1 1"/></geometry></visual></link>'
        f'<link name="arm"><visual><geometry><mesh filename="{mesh}"/></geometry></visual></link>'
        '<joint name="lift" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1"/></joint></robot>'
    )


def packed(folder: Path, files: dict[str, bytes | str]) -> Path:
    """Return a zip of these files."""
    path = folder / "upload.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return path


def cube(kind: str) -> bytes:
    """Return a cube in a format."""
    data = trimesh.creation.box().export(file_type=kind)
    return data.encode() if isinstance(data, str) else bytes(data)


@pytest.mark.parametrize("kind", ["stl", "obj", "dae", "glb"])
def test_a_mesh_of_each_format_is_read_and_kept(tmp_path: Path, kind: str) -> None:
    archive = packed(tmp_path, {"own/robot.urdf": robot(f"meshes/a.{kind}"), f"own/meshes/a.{kind}": cube(kind)})
    told = read_upload(archive, tmp_path / "kept")
    assert told["joints"] == ["lift"]
    assert told["faces"] == 24
    assert told["notices"] == []
    model, skin = load_kept(tmp_path / "kept")
    assert model.joints[0].upper == 1.0
    assert float(np.abs(skin.links["arm"].corners).max()) == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(
    "name", ["package://own/meshes/a.stl", "package://meshes/a.stl", "package:///own/meshes/a.stl"]
)
def test_a_package_address_finds_a_file_of_the_upload_and_nothing_else(tmp_path: Path, name: str) -> None:
    archive = packed(tmp_path, {"robot.urdf": robot(name), "meshes/a.stl": cube("stl")})
    assert read_upload(archive, tmp_path / "kept")["notices"] == []


def test_a_package_file_is_found_wherever_its_folder_was_packed(tmp_path: Path) -> None:
    """As published: the package's name and folders above the ones that were packed, the URDF in a folder beside."""
    name = "package://all_robots/robots/own_description/meshes/visual/a.stl"
    files = {"own_description/urdf/own.urdf": robot(name), "own_description/meshes/visual/a.stl": cube("stl")}
    assert read_upload(packed(tmp_path, files), tmp_path / "kept")["notices"] == []


def test_of_two_files_that_a_package_address_may_mean_none_is_guessed(tmp_path: Path) -> None:
    files = {"robot.urdf": robot("package://own/a.stl"), "left/a.stl": cube("stl"), "right/a.stl": cube("stl")}
    assert "A box stands in" in read_upload(packed(tmp_path, files), tmp_path / "kept")["notices"][0]


def test_a_missing_mesh_is_a_box_with_a_notice(tmp_path: Path) -> None:
    told = read_upload(packed(tmp_path, {"robot.urdf": robot("meshes/gone.stl")}), tmp_path / "kept")
    assert told["faces"] == 24
    assert told["notices"] == ['Link "arm": there is no "meshes/gone.stl" in the upload. A box stands in for it.']


@pytest.mark.parametrize(
    "name",
    [
        "../secret.stl",
        "meshes/../../secret.stl",
        "%2e%2e/secret.stl",
        "..\\\\secret.stl",
        "/etc/passwd",
        "file:///etc/passwd",
        "http://192.0.2.1/a.stl",
        "package://../secret.stl",
        "package://own/../../secret.stl",
        "C:/secret.stl",
    ],
)
def test_a_mesh_outside_the_upload_is_refused_by_its_link(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.stl").write_bytes(cube("stl"))
    with pytest.raises(UnsafeModel, match='Link "arm"'):
        read_upload(packed(tmp_path, {"robot.urdf": robot(name)}), tmp_path / "kept")
    assert not (tmp_path / "kept").exists()


@pytest.mark.parametrize("name", ["../robot.urdf", "/robot.urdf", "a/../../robot.urdf"])
def test_a_zip_that_leads_out_of_its_folder_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(UnsafeModel, match="leads out"):
        read_upload(packed(tmp_path, {name: robot("a.stl")}), tmp_path / "kept")


def test_a_link_in_the_zip_is_refused(tmp_path: Path) -> None:
    info = zipfile.ZipInfo("meshes/a.stl")
    info.external_attr = 0o120777 << 16
    path = tmp_path / "upload.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("robot.urdf", robot("meshes/a.stl"))
        archive.writestr(info, "/etc/passwd")
    with pytest.raises(UnsafeModel):
        read_upload(path, tmp_path / "kept")


@pytest.mark.slow
def test_a_zip_bomb_is_refused(tmp_path: Path) -> None:
    bomb = {"robot.urdf": robot("a.stl"), "a.stl": b"\0" * (130 * 2**20)}
    with pytest.raises(UnsafeModel, match="Unpacked"):
        read_upload(packed(tmp_path, bomb), tmp_path / "kept")


def test_an_stl_that_claims_millions_of_faces_is_refused(tmp_path: Path) -> None:
    lie = b"\0" * 80 + struct.pack("<I", 90_000_000) + b"\0" * 100
    with pytest.raises(UnsafeModel, match="faces"):
        read_upload(packed(tmp_path, {"robot.urdf": robot("a.stl"), "a.stl": lie}), tmp_path / "kept")


def glb(head: dict[str, object]) -> bytes:
    """Return a GLB with this head and no body."""
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    chunk = struct.pack("<I4s", len(text), b"JSON") + text
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunk)) + chunk


def test_a_glb_packed_with_draco_is_refused_for_its_decoder_comes_from_the_internet(tmp_path: Path) -> None:
    data = glb({"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_draco_mesh_compression"]})
    with pytest.raises(UnsafeModel, match="draco"):
        read_upload(packed(tmp_path, {"robot.urdf": robot("a.glb"), "a.glb": data}), tmp_path / "kept")


def test_a_glb_that_refers_to_another_file_is_refused(tmp_path: Path) -> None:
    data = glb({"asset": {"version": "2.0"}, "buffers": [{"uri": "../../etc/passwd", "byteLength": 4}]})
    with pytest.raises(UnsafeModel, match="another file"):
        read_upload(packed(tmp_path, {"robot.urdf": robot("a.glb"), "a.glb": data}), tmp_path / "kept")


def test_a_dae_with_entities_is_refused(tmp_path: Path) -> None:
    data = b'<!DOCTYPE COLLADA [<!ENTITY x SYSTEM "file:///etc/passwd">]><COLLADA>&x;</COLLADA>'
    with pytest.raises(UnsafeModel, match="entities"):
        read_upload(packed(tmp_path, {"robot.urdf": robot("a.dae"), "a.dae": data}), tmp_path / "kept")


@pytest.mark.parametrize("coding", ["utf-16", "utf-16-le", "utf-32", "utf-7"])
def test_a_dae_whose_encoding_hides_what_it_declares_is_refused(tmp_path: Path, coding: str) -> None:
    said = f'<?xml version="1.0" encoding="{coding}"?>' + '<!DOCTYPE c [<!ENTITY x "1 2 3">]><COLLADA>&x;</COLLADA>'
    data = said.encode(coding) if coding != "utf-7" else said.replace("<!", "+ADw-!").encode()
    with pytest.raises(UnsafeModel, match="UTF-8"):
        read_upload(packed(tmp_path, {"robot.urdf": robot("a.dae"), "a.dae": data}), tmp_path / "kept")


def test_a_damaged_zip_and_names_that_no_disk_takes_are_the_uploads_fault(tmp_path: Path) -> None:
    whole = packed(tmp_path, {"robot.urdf": robot("a.stl"), "a.stl": cube("stl") * 40})
    torn = bytearray(whole.read_bytes())
    at = torn.rindex(b"a.stl", 0, torn.index(b"PK\x01\x02")) + 5
    torn[at : at + 60] = b"\xff" * 60
    whole.write_bytes(torn)
    with pytest.raises(ModelError, match="Pack it once more"):
        read_upload(whole, tmp_path / "kept")
    for files in ({"a.stl": cube("stl"), "a.stl/b.stl": cube("stl")}, {"a" * 300 + ".stl": cube("stl")}):
        with pytest.raises(ModelError, match="names in the zip"):
            read_upload(packed(tmp_path, {"robot.urdf": robot("a.stl"), **files}), tmp_path / "kept")
    long = packed(tmp_path, {"robot.urdf": robot("a" * 300 + ".stl")})
    assert "A box stands in" in read_upload(long, tmp_path / "kept")["notices"][0]


def test_an_escaped_name_is_found_beside_a_urdf_in_a_folder(tmp_path: Path) -> None:
    files = {"own/robot.urdf": robot("my%20meshes/a.stl"), "own/my meshes/a.stl": cube("stl")}
    assert read_upload(packed(tmp_path, files), tmp_path / "kept")["notices"] == []


def test_corners_that_are_no_numbers_are_refused(tmp_path: Path) -> None:
    data = b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    with pytest.raises(ModelError, match='Link "arm"'):
        read_upload(packed(tmp_path, {"robot.urdf": robot("a.obj"), "a.obj": data}), tmp_path / "kept")


def test_a_dae_without_a_shape_is_a_box_with_a_notice(tmp_path: Path) -> None:
    dae = (
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/><library_visual_scenes>'
        '<visual_scene id="s"><node/></visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )
    told = read_upload(packed(tmp_path, {"robot.urdf": robot("a.dae"), "a.dae": dae}), tmp_path / "kept")
    assert told["notices"] == ['Link "arm": no triangles were found in "a.dae". A box stands in for it.']


def test_a_model_in_millimetres_is_told_about_its_scale(tmp_path: Path) -> None:
    mesh = trimesh.creation.box(extents=(2600, 1700, 1600)).export(file_type="stl")
    with pytest.raises(ModelError, match="millimetres"):
        read_upload(packed(tmp_path, {"robot.urdf": robot("a.stl"), "a.stl": bytes(mesh)}), tmp_path / "kept")


def test_a_broken_mesh_names_link_and_file(tmp_path: Path) -> None:
    archive = packed(tmp_path, {"robot.urdf": robot("a.stl"), "a.stl": b"solid nothing"})
    with pytest.raises(ModelError, match=r'Link "arm": "a\.stl"'):
        read_upload(archive, tmp_path / "kept")


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({"readme.txt": "x"}, "no .urdf"),
        ({"a.urdf": robot("a.stl"), "b.urdf": robot("a.stl")}, "several"),
        ({"robot.urdf.xacro": "<robot/>"}, "xacro"),
    ],
)
def test_what_holds_no_single_urdf_is_refused(tmp_path: Path, files: dict[str, bytes | str], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        read_upload(packed(tmp_path, files), tmp_path / "kept")


def test_a_refused_upload_leaves_the_model_before_in_place(tmp_path: Path) -> None:
    read_upload(packed(tmp_path, {"robot.urdf": robot("gone.stl")}), tmp_path / "kept")
    with pytest.raises(ModelError):
        read_upload(packed(tmp_path, {"readme.txt": "x"}), tmp_path / "kept")
    assert load_kept(tmp_path / "kept")[0].name == "own"


def test_what_is_no_zip_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "upload.zip"
    path.write_bytes(io.BytesIO(b"PK nothing").getvalue())
    with pytest.raises(ModelError, match="no zip"):
        read_upload(path, tmp_path / "kept")


def test_what_macos_adds_to_a_zip_is_no_model(tmp_path: Path) -> None:
    files: dict[str, bytes | str] = {
        "own/robot.urdf": robot("meshes/a.stl"),
        "own/meshes/a.stl": cube("stl"),
        "own/.DS_Store": b"\0",
        "__MACOSX/own/._robot.urdf": b"\0\5\26\7",
        "__MACOSX/own/robot.urdf": b"\0\5\26\7",
        "own/._robot.urdf": b"\0\5\26\7",
    }
    assert read_upload(packed(tmp_path, files), tmp_path / "kept")["name"] == "own"


def test_a_urdf_is_known_by_its_suffix_in_any_case(tmp_path: Path) -> None:
    files: dict[str, bytes | str] = {"ROBOT.URDF": robot("a.stl"), "a.stl": cube("stl")}
    assert read_upload(packed(tmp_path, files), tmp_path / "kept")["name"] == "own"


def test_a_joint_whose_limits_are_both_0_is_said_not_to_move(tmp_path: Path) -> None:
    stiff = robot("a.stl").replace('<limit lower="-1" upper="1"/>', '<limit effort="10" velocity="1"/>')
    told = read_upload(packed(tmp_path, {"robot.urdf": stiff, "a.stl": cube("stl")}), tmp_path / "kept")
    assert told["notices"] == ['Joint "lift": its limits are both 0, it will not move.']
    assert load_kept(tmp_path / "kept")[0].notices == tuple(told["notices"])
