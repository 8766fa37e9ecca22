"""What people and programs may send: strict, nothing unknown, nothing that is not a number."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from hmi.domain.ids import ID_PATTERN


class Body(BaseModel):
    """Root of all request bodies."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


def _printable(text: str) -> str:
    if not text.isprintable():
        raise ValueError("control characters are not allowed")
    return text


def _one_line(text: str) -> str:
    return _printable(" ".join(text.split()))


def _some(text: str) -> str:
    if not text:
        raise ValueError("it is empty: give it a name that people know")
    return text


Id = Annotated[str, Field(pattern=ID_PATTERN.removesuffix("$") + r"\z", description="lower-case id")]
Ref = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._:-]{7,63}\z", description="UUID or the like")]
Tick = Annotated[str, Field(max_length=80, description="id of the newest tick of the live lane")]
Name = Annotated[str, Field(min_length=1, max_length=80), AfterValidator(_one_line), AfterValidator(_some)]
Reason = Annotated[str, Field(max_length=200), AfterValidator(_one_line)]
Line = Annotated[str, Field(max_length=200), AfterValidator(_printable)]
Secret = Annotated[str, Field(max_length=1024)]
