"""Pictures never fill their room, and what goes is the oldest."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.picture import ROUTINE, PictureKind
from hmi.domain.picture_retention import Retention, too_many

NOW = datetime(2026, 5, 4, 12, tzinfo=UTC)
RULES = Retention(most_bytes=1000, most_age=timedelta(days=30), free_bytes=0)


@dataclass(frozen=True)
class One:
    """A picture."""

    id: str
    kind: PictureKind
    captured_at: datetime
    size_bytes: int
    is_kept: bool = False


def one(number: int, age_days: float, size: int, kind: str = "snapshot", *, kept: bool = False) -> One:
    """Return a picture of an age."""
    return One(f"p{number:04}", PictureKind(kind), NOW - timedelta(days=age_days), size, kept)


ROWS = st.tuples(
    st.floats(0, 60), st.integers(1, 400), st.sampled_from([kind.value for kind in PictureKind]), st.booleans()
)


def farm_of(rows: list[tuple[float, int, str, bool]]) -> list[One]:
    """Return pictures, a few of them marked."""
    return [one(i, age, size, kind, kept=kept and i % 3 == 0) for i, (age, size, kind, kept) in enumerate(rows)]


PICTURES = st.lists(ROWS, max_size=30).map(farm_of)


@given(PICTURES)
def test_after_a_sweep_it_is_never_above_the_limit_unless_what_is_marked_is(held: list[One]) -> None:
    gone = set(too_many(held, NOW, RULES))
    marked = sum(p.size_bytes for p in held if p.is_kept)
    assert sum(p.size_bytes for p in held if p.id not in gone) <= max(RULES.most_bytes, marked)


@given(PICTURES)
def test_what_is_marked_stays_and_what_is_too_old_goes(held: list[One]) -> None:
    gone = set(too_many(held, NOW, RULES))
    for p in held:
        if p.is_kept:
            assert p.id not in gone
        elif NOW - p.captured_at > RULES.most_age:
            assert p.id in gone


@given(PICTURES)
def test_nothing_older_stays_of_its_kind_when_something_newer_went(held: list[One]) -> None:
    gone = set(too_many(held, NOW, RULES))
    loose = [p for p in held if not p.is_kept]
    for is_routine in (True, False):
        same = sorted((p for p in loose if (p.kind in ROUTINE) is is_routine), key=lambda p: (p.captured_at, p.id))
        went = [p.id in gone for p in same]
        assert went == sorted(went, reverse=True)


@given(PICTURES)
def test_a_second_sweep_finds_nothing_to_do(held: list[One]) -> None:
    gone = set(too_many(held, NOW, RULES))
    assert too_many([p for p in held if p.id not in gone], NOW, RULES) == []


def test_the_newest_stay() -> None:
    held = [one(i, age_days=i, size=300) for i in range(6)]
    assert too_many(held, NOW, RULES) == ["p0003", "p0004", "p0005"]


def test_frames_that_come_all_day_leave_half_of_the_room_to_evidence() -> None:
    evidence = [one(i, age_days=20 + i, size=100, kind="clip") for i in range(5)]
    frames = [one(100 + i, age_days=i / 10, size=100, kind="frame") for i in range(50)]
    gone = set(too_many([*evidence, *frames], NOW, RULES))
    assert not gone & {p.id for p in evidence}
    assert len(frames) - len(gone) == 5
