"""Which model a robot has: what an admin uploaded, else that of its family, else a plain one of its size."""

from __future__ import annotations

import logging
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np

from backend_clients.edge.messages_up import Factsheet
from hmi.twin.errors import ModelError
from hmi.twin.machine import Form
from hmi.twin.mesh_files import MeshFolder
from hmi.twin.model import Box, Cylinder, Model, Visual
from hmi.twin.skin import skin_of
from hmi.twin.upload import MODEL, load_kept
from hmi.twin.urdf import parse_urdf

OWN = Path(__file__).resolve().parents[2] / "static" / "models"
FAMILIES = ("weeder", "planter", "uav")
log = logging.getLogger(__name__)


class Library:
    """Models by robot. ``uploads`` holds one folder for each robot with a model of its own.

    An upload may be large: it is made ready in a thread, and the robot has another model until then.
    """

    def __init__(self, uploads: Path) -> None:
        self._uploads = uploads
        self._forms: dict[tuple[str, str], Form] = {}
        self._own: dict[str, tuple[int, Future[Form | None]]] = {}
        self._reader = ThreadPoolExecutor(1, "twin-model")

    def close(self) -> None:
        """Make no further model ready."""
        self._reader.shutdown(wait=False, cancel_futures=True)

    def kind_of(self, factsheet: Factsheet) -> str:
        """Return where a robot's model comes from: upload, family or plain; loading while an upload is made ready."""
        own = self._uploaded(factsheet.robot)
        if own is not None and not own.done():
            return "loading"
        if own is not None and own.result() is not None:
            return "upload"
        return "family" if factsheet.family in FAMILIES else "plain"

    def form(self, factsheet: Factsheet) -> Form:
        """Return the model of a robot; a kept upload that is not ready or damaged falls back to the family's."""
        own = self._uploaded(factsheet.robot)
        form = own.result() if own is not None and own.done() else None
        return form or self._stock(factsheet)

    def _stock(self, factsheet: Factsheet) -> Form:
        is_family = factsheet.family in FAMILIES
        key = ("family", factsheet.family) if is_family else ("plain", f"{factsheet.dimensions}")
        if key not in self._forms:
            model = own_model(factsheet.family) if is_family else plain_model(factsheet)
            self._forms[key] = Form.of(model, skin_of(model, MeshFolder(OWN).read))
        return self._forms[key]

    def _uploaded(self, robot_id: str) -> Future[Form | None] | None:
        """Return a robot's own model, which may be on its way; it is read again when it was uploaded again."""
        try:
            stamp = (self._uploads / robot_id / MODEL).stat().st_mtime_ns
        except OSError:
            self._own.pop(robot_id, None)
            return None
        known = self._own.get(robot_id)
        if known is None or known[0] != stamp:
            known = self._own[robot_id] = (stamp, self._reader.submit(_read, self._uploads / robot_id))
        return known[1]


def _read(folder: Path) -> Form | None:
    try:
        return Form.of(*load_kept(folder))
    except ModelError as error:
        log.warning("%s", error)
    except Exception:  # whatever an upload holds, its robot is drawn some other way
        log.exception("the model in %s cannot be drawn", folder.name)
    return None


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
