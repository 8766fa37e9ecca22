"""Which model a robot is drawn with, and when an upload is."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from backend_clients.edge import messages_up as up
from hmi.twin import library as library_module
from hmi.twin.errors import ModelError
from hmi.twin.library import Library, plain_model
from hmi.twin.model import Model
from hmi.twin.skin import LinkSkin, Skin
from hmi.twin.upload import MODEL

FACTSHEET = up.Factsheet(
    robot="digger-01", boot="boot-0001", seq=1, mono_ms=1, wall_ms=0,
    family="weeder", name="Digger 01", model="Digger", software="1",
    datum=up.Datum(lat_deg=52.0, lon_deg=5.0),
    dimensions=up.Dimensions(length_m=2.0, width_m=1.0, height_m=1.0, base_to_front_m=1.0),
    limits=up.Limits(max_speed_mps=2.0, max_accel_mps2=1.0, decel_mps2=1.0, max_yaw_rate_radps=1.0),
)  # fmt: skip


class Shelf:
    """Kept uploads that can be read when the test lets them."""

    def __init__(self) -> None:
        self.is_readable, self.threads = threading.Event(), list[str]()
        self.problem: Exception | None = None

    def read(self, _folder: Path) -> tuple[Model, Skin]:
        """Stand in for ``load_kept``."""
        self.threads.append(threading.current_thread().name)
        assert self.is_readable.wait(10)
        if self.problem is not None:
            raise self.problem
        corners = np.asarray([(0, 0, 0), (3, 0, 0), (0, 1, 0)], np.float32)
        return plain_model(FACTSHEET), Skin({"base": LinkSkin(corners, np.zeros((3, 3), np.uint8))})


@pytest.fixture
def shelf(monkeypatch: pytest.MonkeyPatch) -> Shelf:
    """What the library reads uploads from."""
    made = Shelf()
    monkeypatch.setattr(library_module, "load_kept", made.read)
    return made


@pytest.fixture
def library(tmp_path: Path, shelf: Shelf) -> Iterator[Library]:
    """A library whose one robot has a model of its own."""
    made = Library(tmp_path)
    (tmp_path / FACTSHEET.robot).mkdir()
    (tmp_path / FACTSHEET.robot / MODEL).write_text("{}")
    yield made
    shelf.is_readable.set()
    made.close()


def settled(library: Library) -> str:
    """Return where the model comes from when it was read."""
    deadline_s = time.monotonic() + 10
    while (kind := library.kind_of(FACTSHEET)) == "loading":
        assert time.monotonic() < deadline_s
        time.sleep(0.005)
    return kind


def test_nobody_waits_for_an_upload_and_the_family_stands_in_meanwhile(library: Library, shelf: Shelf) -> None:
    stand_in = library.form(FACTSHEET)
    assert library.kind_of(FACTSHEET) == "loading"
    assert stand_in.model.name != "plain"
    assert library.form(FACTSHEET) is stand_in
    shelf.is_readable.set()
    assert settled(library) == "upload"
    assert library.form(FACTSHEET).size_m == 3.0
    assert len(shelf.threads) == 1, "it is read once"
    assert threading.current_thread().name not in shelf.threads


@pytest.mark.parametrize("problem", [ModelError("damaged"), RuntimeError("strange")])
def test_an_upload_that_cannot_be_read_leaves_the_family(library: Library, shelf: Shelf, problem: Exception) -> None:
    shelf.problem = problem
    shelf.is_readable.set()
    library.form(FACTSHEET)
    assert settled(library) == "family"
    assert library.form(FACTSHEET).model.name != "plain"
    assert len(shelf.threads) == 1, "not again at each picture"


def test_a_model_that_is_taken_away_is_gone_at_once(library: Library, shelf: Shelf, tmp_path: Path) -> None:
    shelf.is_readable.set()
    library.form(FACTSHEET)
    assert settled(library) == "upload"
    (tmp_path / FACTSHEET.robot / MODEL).unlink()
    assert library.kind_of(FACTSHEET) == "family"
