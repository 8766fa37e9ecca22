"""What is seen of a model: coloured triangles for each link, ready to be sent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hmi.twin.errors import UnsafeModel
from hmi.twin.glb import GHOST_ALPHA, glb_of
from hmi.twin.limits import MAX_FACES
from hmi.twin.model import GREY, MeshFile, Model, Visual
from hmi.twin.solids import Floats, placed, triangles_of

ReadMesh = Callable[[MeshFile, str], tuple[Floats, NDArray[np.uint8] | None]]
"""Mesh and link to (3N, 3) corners and their own colours, if it has any."""


@dataclass(frozen=True, slots=True)
class LinkSkin:
    """Corners (3N, 3) in the link's frame and their colours (3N, 3)."""

    corners: Floats
    colours: NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Skin:
    """The skins of a model's links that have any."""

    links: dict[str, LinkSkin]

    def glbs(self, *, is_ghost: bool = False) -> dict[str, bytes]:
        """Return a GLB for each link."""
        alpha = GHOST_ALPHA if is_ghost else 1.0
        return {link: glb_of(skin.corners, skin.colours, alpha=alpha) for link, skin in self.links.items()}

    @property
    def faces(self) -> int:
        """How many triangles there are."""
        return sum(len(skin.corners) for skin in self.links.values()) // 3


def skin_of(model: Model, read_mesh: ReadMesh) -> Skin:
    """Return the skin of a model.

    Raises:
        ModelError: a mesh cannot be read.
        UnsafeModel: there are too many triangles.
    """
    links: dict[str, LinkSkin] = {}
    faces = 0
    for link, visuals in model.links.items():
        parts = [_part(visual, link, read_mesh) for visual in visuals]
        if parts:
            links[link] = LinkSkin(np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts]))
            faces += len(links[link].corners) // 3
        if faces > MAX_FACES:
            raise UnsafeModel(f'Link "{link}": the model has over {MAX_FACES} triangles here. Simplify its meshes.')
    return Skin(links)


def _part(visual: Visual, link: str, read_mesh: ReadMesh) -> tuple[Floats, NDArray[np.uint8]]:
    own = None
    if isinstance(visual.geometry, MeshFile):
        corners, own = read_mesh(visual.geometry, link)
        corners = np.asarray(corners * np.asarray(visual.geometry.scale), dtype=np.float32)
    else:
        corners = triangles_of(visual.geometry)
    if visual.colour is not None or own is None:
        own = np.tile(np.asarray(visual.colour or GREY, np.uint8), (len(corners), 1))
    return placed(corners, visual.xyz, visual.rpy), own
