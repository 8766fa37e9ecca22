"""URDF to ``Model``, trusting nothing: no document types, no files, finite numbers, one tree.

Source: the URDF XML format of ROS (wiki.ros.org/urdf/XML), links' visuals and joints only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from xml.etree.ElementTree import Element, ParseError  # names only; parsing is done by defusedxml

from defusedxml import DefusedXmlException, ElementTree

from hmi.twin.errors import ModelError, UnsafeModel
from hmi.twin.limits import MAX_DEPTH, MAX_LINKS, MAX_SIZE_M, MAX_URDF_BYTES, MAX_VISUALS
from hmi.twin.model import (
    MOVING,
    Box,
    Colour,
    Cylinder,
    Geometry,
    MeshFile,
    Mimic,
    Model,
    ModelJoint,
    Sphere,
    Vector,
    Visual,
)
from hmi.twin.tree import in_tree_order

_KINDS = {*MOVING, "fixed"}
XACRO = "This is xacro, not URDF. Run `xacro robot.urdf.xacro > robot.urdf` and upload what it writes."


def parse_urdf(data: bytes) -> Model:
    """Return the model.

    Raises:
        ModelError: it is no URDF, or broken; the link or joint is named.
        UnsafeModel: it declares entities, or is too large.
    """
    root = _xml(data)
    if _local(root) != "robot":
        raise ModelError(f"The first element is <{_local(root)[:40]}>, a URDF starts with <robot>.")
    if any("xacro" in str(element.tag) for element in root.iter()):
        raise ModelError(XACRO)
    colours = dict(_materials(root))
    links = _links(root, colours)
    joints = tuple(_joint(element) for element in _children(root, "joint"))
    top, ordered = in_tree_order(set(links), joints)
    return Model(str(root.get("name") or "robot")[:80], top, links, ordered, tuple(_stiff(ordered)))


def _stiff(joints: Iterable[ModelJoint]) -> Iterator[str]:
    """A <limit> that names only effort and velocity is common, and means 0 to 0."""
    for joint in joints:
        if joint.moves and joint.lower == joint.upper == 0:
            yield f'Joint "{joint.name}": its limits are both 0, it will not move.'


def _xml(data: bytes) -> Element:
    if len(data) > MAX_URDF_BYTES:
        raise UnsafeModel(f"The URDF has {len(data) // 1024} kB, at most {MAX_URDF_BYTES // 1024} kB are read.")
    try:
        root: Element = ElementTree.fromstring(data, forbid_dtd=True, forbid_entities=True, forbid_external=True)
    except DefusedXmlException as error:
        raise UnsafeModel("The URDF declares a document type or entities. Robots need none; it is refused.") from error
    except (ParseError, ValueError, LookupError) as error:
        where = f" in line {error.position[0]}" if isinstance(error, ParseError) else ""
        raise ModelError(f"The URDF is broken{where}: it is no well-formed XML.") from error
    level, depth = [root], 0
    while level:
        depth += 1
        if depth > MAX_DEPTH:
            raise UnsafeModel("The URDF is nested too deeply. It is refused.")
        level = [below for element in level for below in element]
    return root


def _links(root: Element, colours: dict[str, Colour]) -> dict[str, tuple[Visual, ...]]:
    links: dict[str, tuple[Visual, ...]] = {}
    for element in _children(root, "link"):
        name = _link(element, "link")
        if name in links:
            raise ModelError(f'Two links are called "{name}".')
        links[name] = tuple(_visual(visual, name, colours) for visual in _children(element, "visual"))
    if not links:
        raise ModelError("The URDF has no link.")
    if len(links) > MAX_LINKS or sum(map(len, links.values())) > MAX_VISUALS:
        raise UnsafeModel(f"The URDF has over {MAX_LINKS} links or {MAX_VISUALS} visuals.")
    return links


def _visual(element: Element, link: str, colours: dict[str, Colour]) -> Visual:
    where = f'Link "{link}"'
    shape = next(iter(_children(element, "geometry")), None)
    inner = next(iter(shape), None) if shape is not None else None
    if inner is None:
        raise ModelError(f"{where}: a visual has no geometry.")
    xyz, rpy = _origin(element, where)
    return Visual(_geometry(inner, where), xyz, rpy, _colour_of(element, where, colours))


def _geometry(element: Element, where: str) -> Geometry:
    match _local(element):
        case "box":
            return Box(_lengths(element, "size", where))
        case "cylinder":
            return Cylinder(_length(element, "radius", where), _length(element, "length", where))
        case "sphere":
            return Sphere(_length(element, "radius", where))
        case "mesh":
            name = element.get("filename")
            if not name:
                raise ModelError(f"{where}: a mesh names no file.")
            return MeshFile(name, _vector(element.get("scale", "1 1 1"), f"{where}: scale"))
        case other:
            raise ModelError(f"{where}: geometry <{other[:40]}> is not known; use box, cylinder, sphere or mesh.")


def _joint(element: Element) -> ModelJoint:
    name = _name(element, "joint")
    where = f'Joint "{name}"'
    kind = element.get("type", "")
    if kind not in _KINDS:
        raise ModelError(f"{where}: type {kind[:40]!r} cannot be shown; use revolute, continuous, prismatic or fixed.")
    xyz, rpy = _origin(element, where)
    limit = next(iter(_children(element, "limit")), None)
    lower, upper = _limits(limit, where) if kind in ("revolute", "prismatic") else (None, None)
    return ModelJoint(
        name,
        kind,
        _named(element, "parent", where),
        _named(element, "child", where),
        xyz,
        rpy,
        _axis(element, where) if kind in MOVING else (1.0, 0.0, 0.0),
        lower,
        upper,
        _mimic(element, where),
    )


def _limits(element: Element | None, where: str) -> tuple[float | None, float | None]:
    if element is None:
        return None, None
    lower, upper = (_number(element.get(key, "0"), f"{where}: limit {key}") for key in ("lower", "upper"))
    if lower > upper:
        raise ModelError(f"{where}: its lower limit {lower} is above its upper limit {upper}.")
    return lower, upper


def _mimic(element: Element, where: str) -> Mimic | None:
    found = next(iter(_children(element, "mimic")), None)
    if found is None:
        return None
    factor = _number(found.get("multiplier", "1"), f"{where}: mimic multiplier")
    return Mimic(_name(found, "mimic", "joint"), factor, _number(found.get("offset", "0"), f"{where}: mimic offset"))


def _axis(element: Element, where: str) -> Vector:
    found = next(iter(_children(element, "axis")), None)
    x, y, z = _vector(found.get("xyz", "1 0 0"), f"{where}: axis") if found is not None else (1.0, 0.0, 0.0)
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-6:
        raise ModelError(f"{where}: its axis has no direction.")
    return x / length, y / length, z / length


def _origin(element: Element, where: str) -> tuple[Vector, Vector]:
    found = next(iter(_children(element, "origin")), None)
    if found is None:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    xyz = _vector(found.get("xyz", "0 0 0"), f"{where}: origin xyz")
    if max(map(abs, xyz)) > MAX_SIZE_M:
        raise ModelError(f"{where}: its origin lies {max(map(abs, xyz)):.0f} m away. URDF counts in metres.")
    return xyz, _vector(found.get("rpy", "0 0 0"), f"{where}: origin rpy")


def _materials(root: Element) -> Iterator[tuple[str, Colour]]:
    for material in _children(root, "material"):
        colour = _rgba(material, "material")
        if colour is not None:
            yield str(material.get("name")), colour


def _colour_of(element: Element, where: str, colours: dict[str, Colour]) -> Colour | None:
    material = next(iter(_children(element, "material")), None)
    if material is None:
        return None
    return _rgba(material, where) or colours.get(str(material.get("name")))


def _rgba(material: Element, where: str) -> Colour | None:
    found = next(iter(_children(material, "color")), None)
    if found is None:
        return None
    red, green, blue, *_ = _numbers(found.get("rgba", ""), (3, 4), f"{where}: colour")
    return _channel(red), _channel(green), _channel(blue)


def _channel(value: float) -> int:
    return round(255 * min(1.0, max(0.0, value)))


def _lengths(element: Element, key: str, where: str) -> Vector:
    x, y, z = _vector(element.get(key, ""), f"{where}: {key}")
    for value in (x, y, z):
        _check_size(value, where)
    return x, y, z


def _length(element: Element, key: str, where: str) -> float:
    value = _number(element.get(key, ""), f"{where}: {key}")
    _check_size(value, where)
    return value


def _check_size(value: float, where: str) -> None:
    if not 0 < value <= MAX_SIZE_M:
        raise ModelError(f"{where}: a size of {value:g} m is none a machine has. URDF counts in metres.")


def _vector(text: str, where: str) -> Vector:
    x, y, z = _numbers(text, (3,), where)
    return x, y, z


def _numbers(text: str, counts: tuple[int, ...], where: str) -> list[float]:
    words = text.split()
    if len(words) not in counts:
        raise ModelError(f"{where}: {text[:60]!r} is not {' or '.join(map(str, counts))} numbers.")
    return [_number(word, where) for word in words]


def _number(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise ModelError(f"{where}: {text[:40]!r} is not a number.") from None
    if not math.isfinite(value):
        raise ModelError(f"{where}: {text[:40]!r} is not a finite number.")
    return value


def _name(element: Element, kind: str, key: str = "name") -> str:
    name = element.get(key, "").strip()
    if not name or len(name) > 120:
        raise ModelError(f"A {kind} has no usable name: {name[:40]!r}.")
    return name


def _link(element: Element, kind: str, key: str = "name") -> str:
    """A link's name; simulators write some with slashes, which divide frames here."""
    return _name(element, kind, key).replace("/", "_")


def _named(element: Element, tag: str, where: str) -> str:
    found = next(iter(_children(element, tag)), None)
    if found is None:
        raise ModelError(f"{where}: it names no {tag} link.")
    return _link(found, tag, "link")


def _local(element: Element) -> str:
    return str(element.tag).rsplit("}", 1)[-1]


def _children(element: Element, name: str) -> Iterator[Element]:
    return (child for child in element if _local(child) == name)
