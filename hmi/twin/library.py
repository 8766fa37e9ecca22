"""Which model a robot has: what an admin uploaded, else that of its family, else a plain one of its size."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from backend_clients.edge.messages_up import Factsheet
from hmi.twin.errors import ModelError
from hmi.twin.machine import Form
from hmi.twin.mesh_files import MeshFolder
from hmi.twin.model import Box, Cylinder, Model, Visual
from hmi.twin.skin import Skin, skin_of
from hmi.twin.upload import MODEL, load_kept
from hmi.twin.urdf import parse_urdf

OWN = Path(__file__).resolve().parents[2] / "static" / "models"
FAMILIES = ("weeder", "planter", "uav")


class Library:
    """Models by robot. ``uploads`` holds one folder for each robot with a model of its own."""

    def __init__(self, uploads: Path) -> None:
        self._uploads = uploads
        self._forms: dict[tuple[str, ...], Form] = {}

    def kind_of(self, factsheet: Factsheet) -> str:
        """Return where a robot's model comes from: upload, family or plain."""
        if (self._uploads / factsheet.robot / MODEL).is_file():
            return "upload"
        return "family" if factsheet.family in FAMILIES else "plain"

    def form(self, factsheet: Factsheet) -> Form:
        """Return the model of a robot; a kept upload that is damaged falls back to the family's."""
        kind = self.kind_of(factsheet)
        if kind == "upload":
            try:
                return self._kept(("upload", factsheet.robot, self._stamp(factsheet.robot)), factsheet)
            except ModelError:
                kind = "family" if factsheet.family in FAMILIES else "plain"
        size = factsheet.dimensions
        key = (kind, factsheet.family) if kind == "family" else ("plain", f"{size}")
        return self._kept(key, factsheet)

    def _kept(self, key: tuple[str, ...], factsheet: Factsheet) -> Form:
        if key not in self._forms:
            self._forms[key] = Form.of(*self._read(key[0], factsheet))
        return self._forms[key]

    def _read(self, kind: str, factsheet: Factsheet) -> tuple[Model, Skin]:
        if kind == "upload":
            return load_kept(self._uploads / factsheet.robot)
        model = own_model(factsheet.family) if kind == "family" else plain_model(factsheet)
        return model, skin_of(model, MeshFolder(OWN).read)

    def _stamp(self, robot_id: str) -> str:
        return str((self._uploads / robot_id / MODEL).stat().st_mtime_ns)


def own_model(family: str) -> Model:
    """Return the model of a family that comes with the product."""
    return parse_urdf((OWN / f"{family}.urdf").read_bytes())


def plain_model(factsheet: Factsheet) -> Model:
    """Return a box of the machine's size with a mast and a nose, for a robot nobody described."""
    size = factsheet.dimensions
    length, width = max(size.length_m, 0.2), max(size.width_m, 0.2)
    height = max(size.height_m, 0.1)
    middle = size.base_to_front_m - length / 2
    body = height * 0.7
    nose = np.clip(0.12 * length, 0.05, 0.6)
    visuals = (
        Visual(Box((length, width, body)), (middle, 0.0, body / 2 + 0.05), colour=(148, 154, 158)),
        Visual(
            Box((float(nose), width * 0.5, body * 0.3)), (middle + length / 2, 0.0, body * 0.6), colour=(36, 66, 82)
        ),
        Visual(Cylinder(0.04, height), (middle - length * 0.3, 0.0, height / 2), colour=(40, 46, 50)),
    )
    return Model("plain", "base", {"base": visuals}, ())
