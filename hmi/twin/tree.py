"""The order of a model's joints: one root, no loops, parents first."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from hmi.twin.errors import ModelError
from hmi.twin.model import ModelJoint


def in_tree_order(links: set[str], joints: Iterable[ModelJoint]) -> tuple[str, tuple[ModelJoint, ...]]:
    """Return the root link and the joints, parents first.

    Raises:
        ModelError: an unknown link, two parents, a loop, several roots, or a mimic that leads nowhere.
    """
    joints = tuple(joints)
    below: dict[str, list[ModelJoint]] = defaultdict(list)
    parent_of: dict[str, str] = {}
    names: set[str] = set()
    for joint in joints:
        for link in (joint.parent, joint.child):
            if link not in links:
                raise ModelError(f'Joint "{joint.name}": there is no link "{link}".')
        if joint.name in names:
            raise ModelError(f'Two joints are called "{joint.name}".')
        if joint.child in parent_of:
            raise ModelError(f'Link "{joint.child}" hangs on two joints, "{joint.name}" is one of them.')
        names.add(joint.name)
        parent_of[joint.child] = joint.parent
        below[joint.parent].append(joint)
    _check_mimics(joints, names)
    roots = sorted(links - parent_of.keys())
    if not roots:
        raise ModelError(f'The links form a loop: "{_in_loop(parent_of)}" is its own ancestor.')
    if len(roots) > 1:
        raise ModelError(f'The model falls apart: "{roots[0]}" and "{roots[1]}" hang on nothing.')
    ordered, open_links = [], [roots[0]]
    while open_links:
        hanging = below[open_links.pop(0)]
        ordered += hanging
        open_links += [joint.child for joint in hanging]
    if len(ordered) < len(joints):
        lost = next(joint.child for joint in joints if joint not in ordered)
        raise ModelError(f'The links form a loop: "{lost}" is its own ancestor.')
    return roots[0], tuple(ordered)


def _check_mimics(joints: tuple[ModelJoint, ...], names: set[str]) -> None:
    followed = {joint.name: joint.mimic.joint for joint in joints if joint.mimic}
    for name, other in followed.items():
        if other not in names:
            raise ModelError(f'Joint "{name}" follows "{other[:60]}", which is not there.')
        if other in followed:
            raise ModelError(f'Joint "{name}" follows "{other}", which itself follows another.')


def _in_loop(parent_of: dict[str, str]) -> str:
    link, seen = next(iter(parent_of)), set()
    while link not in seen:
        seen.add(link)
        link = parent_of[link]
    return link
