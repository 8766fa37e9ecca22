"""URDF from strangers: what is read, and every way in which it is refused."""

from __future__ import annotations

import pytest

from hmi.twin.errors import ModelError, UnsafeModel
from hmi.twin.model import Box, MeshFile
from hmi.twin.urdf import parse_urdf


def urdf(inside: str) -> bytes:
    """Return a robot with these elements."""
    return f'<robot name="r">{inside}</robot>'.encode()


def joint(name: str, parent: str, child: str, kind: str = "revolute", more: str = "") -> str:
    """Return a joint."""
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{more}</joint>'


LINKS = '<link name="a"/><link name="b"/>'
BOX = '<visual><geometry><box size="1 2 3"/></geometry></visual>'


def test_links_joints_limits_and_colours_are_read() -> None:
    limit = '<axis xyz="0 0 2"/><limit lower="-1" upper="2" effort="0" velocity="1"/>'
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    shape = '<visual><geometry><box size="1 2 3"/></geometry><material name="red"/></visual>'
    model = parse_urdf(urdf(f'{red}<link name="a">{shape}</link><link name="b"/>{joint("j", "a", "b", more=limit)}'))
    assert model.root == "a"
    assert model.links["a"][0].geometry == Box((1.0, 2.0, 3.0))
    assert model.links["a"][0].colour == (255, 0, 0)
    assert (model.joints[0].lower, model.joints[0].upper, model.joints[0].axis) == (-1.0, 2.0, (0.0, 0.0, 1.0))


def test_a_mesh_is_named_with_its_scale() -> None:
    mesh = '<visual><geometry><mesh filename="m/a.stl" scale="0.001 0.001 0.001"/></geometry></visual>'
    model = parse_urdf(urdf(f'<link name="a">{mesh}</link>'))
    assert model.links["a"][0].geometry == MeshFile("m/a.stl", (0.001, 0.001, 0.001))


@pytest.mark.parametrize(
    ("inside", "said"),
    [
        (LINKS + joint("j", "a", "c"), 'there is no link "c"'),
        (LINKS + joint("j", "a", "b") + joint("k", "b", "a"), "loop"),
        ('<link name="a"/><link name="b"/><link name="c"/>' + joint("j", "b", "c") + joint("k", "c", "b"), "loop"),
        (LINKS, "falls apart"),
        (LINKS + joint("j", "a", "b") + joint("k", "a", "b"), "two joints"),
        ('<link name="a"/><link name="a"/>', 'Two links are called "a"'),
        (LINKS + joint("j", "a", "b", "floating"), "cannot be shown"),
        (LINKS + joint("j", "a", "b", more='<origin xyz="nan 0 0"/>'), "not a finite number"),
        (LINKS + joint("j", "a", "b", more='<origin xyz="inf 0 0"/>'), "not a finite number"),
        (LINKS + joint("j", "a", "b", more='<axis xyz="0 0 0"/>'), "no direction"),
        (LINKS + joint("j", "a", "b", more='<limit lower="2" upper="1"/>'), "above its upper limit"),
        (LINKS + joint("j", "a", "b", more='<mimic joint="k"/>'), "which is not there"),
        ('<link name="a"><visual><geometry><box size="1 2"/></geometry></visual></link>', "3 numbers"),
        (
            '<link name="a"><visual><geometry><box size="1 2 1e300"/></geometry></visual></link>',
            "is none a machine has",
        ),
        ('<link name="a"><visual><geometry><ball/></geometry></visual></link>', "is not known"),
        ("", "no link"),
    ],
)
def test_a_broken_model_is_refused_with_the_name_of_what_is_wrong(inside: str, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        parse_urdf(urdf(inside))


def test_xacro_is_told_how_to_become_urdf() -> None:
    data = b'<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:property name="x" value="1"/></robot>'
    with pytest.raises(ModelError, match="xacro robot"):
        parse_urdf(data)


@pytest.mark.parametrize(
    "head",
    [
        '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE robot [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>',
        '<!DOCTYPE robot SYSTEM "http://192.0.2.1/x.dtd">',
    ],
)
def test_entities_and_document_types_are_refused(head: str) -> None:
    with pytest.raises(UnsafeModel):
        parse_urdf(f'{head}<robot name="r"><link name="a"/></robot>'.encode())


def test_a_huge_urdf_is_refused_before_it_is_parsed() -> None:
    with pytest.raises(UnsafeModel, match="kB"):
        parse_urdf(b"<robot>" + b" " * 3_000_000)


def test_too_many_links_are_refused() -> None:
    with pytest.raises(UnsafeModel, match="links"):
        parse_urdf(urdf("".join(f'<link name="l{i}"/>' for i in range(300))))


def test_deep_nesting_is_refused() -> None:
    with pytest.raises(UnsafeModel, match="nested"):
        parse_urdf(urdf("<a>" * 100 + "</a>" * 100))


@pytest.mark.parametrize("data", [b"", b"<robot>", b"\x00\x01", b"<html/>", "<robot/>".encode("utf-16")])
def test_what_is_no_urdf_is_refused(data: bytes) -> None:
    with pytest.raises(ModelError):
        parse_urdf(data)


def test_slashes_in_the_names_of_links_are_read_as_simulators_write_them() -> None:
    links = '<link name="base"/><link name="iris/imu/link"/>'
    model = parse_urdf(urdf(links + joint("imu", "base", "iris/imu/link", "fixed")))
    assert list(model.links) == ["base", "iris_imu_link"]
    assert model.joints[0].child == "iris_imu_link"
