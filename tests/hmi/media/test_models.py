"""Models that come in: one that stalls holds up no other, and is given up."""

from __future__ import annotations

import asyncio
import io
import zipfile
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

from hmi.api.twin import ModelRefused
from hmi.app import media_models
from hmi.app.media_models import MediaModels
from hmi.media import models
from hmi.media.models import ModelShelf
from hmi.twin.errors import ModelError

URDF = '<robot name="own"><link name="base"><visual><geometry><box size="1 1 1"/></geometry></visual></link></robot>'


async def stalled() -> AsyncIterator[bytes]:
    """Begin and send nothing more."""
    yield b"PK"
    await asyncio.Event().wait()


async def whole() -> AsyncIterator[bytes]:
    """Send a zip."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as packed:
        packed.writestr("robot.urdf", URDF)
    yield data.getvalue()


def parts(folder: Path) -> list[Path]:
    """Return what is left of uploads that did not come to an end."""
    return list(folder.rglob("*.part"))


async def test_an_upload_that_stalls_holds_up_no_other(tmp_path: Path) -> None:
    shelf = ModelShelf(tmp_path)
    first = asyncio.create_task(shelf.take("weeder-01", stalled()))
    await asyncio.sleep(0)
    async with asyncio.timeout(30):
        assert (await shelf.take("weeder-02", whole()))["name"] == "own"
    first.cancel()
    await asyncio.gather(first, return_exceptions=True)
    assert parts(tmp_path) == []


async def test_an_upload_that_stalls_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(models, "CHUNK_LIMIT_S", 0.01)
    async with asyncio.timeout(10):
        with pytest.raises(ModelError, match=r"^Nothing of the upload came for 20 s\."):
            await ModelShelf(tmp_path).take("weeder-01", stalled())
    assert parts(tmp_path) == []


class Link:
    """Passes on what comes, as the console's way to the media process does."""

    async def upload(self, _path: str, chunks: AsyncIterator[bytes], _limit_s: float) -> Any:
        """Wait for all of it."""
        return [chunk async for chunk in chunks]


async def test_the_console_waits_no_longer_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(media_models, "CHUNK_LIMIT_S", 0.01)
    link: Any = Link()
    async with asyncio.timeout(10):
        with pytest.raises(ModelRefused, match="Upload it once more"):
            await MediaModels(link).take("weeder-01", stalled())
