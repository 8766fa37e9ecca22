"""The features an operation works on, and the draft they stand in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import Shape, frame_of, shape_of
from hmi.mapping.kinds import KINDS, POLYGON
from hmi.planning.projection import LocalFrame

LONGEST_TITLE = 60  # in a label; a log line stays one line


@dataclass(frozen=True, slots=True)
class Selection:
    """The whole draft and the features chosen, at least one, each once."""

    draft: Mapping[str, MapFeature]
    chosen: tuple[MapFeature, ...]

    @classmethod
    def of(cls, draft: Mapping[str, MapFeature], ids: Sequence[str]) -> Selection:
        """Return the selection of these ids.

        Raises:
            OperationRefused: none, one twice, or one that the draft does not hold.
        """
        if not ids:
            raise OperationRefused("nothing_chosen", "Nothing is chosen. Choose a feature on the map first.")
        if len(set(ids)) != len(ids):
            raise OperationRefused("chosen_twice", "A feature is chosen twice. Choose each once.")
        selection = cls(draft, ())
        return cls(draft, tuple(selection.named(one) for one in ids))

    def named(self, feature_id: str) -> MapFeature:
        """Return a feature of the draft.

        Raises:
            OperationRefused: the draft does not hold it.
        """
        if feature_id not in self.draft:
            raise OperationRefused(
                "unknown_feature", f"{feature_id[:64]} is not on this map. It may have been removed; look again."
            )
        return self.draft[feature_id]

    def one(self) -> MapFeature:
        """Return the only feature chosen.

        Raises:
            OperationRefused: more than one is chosen.
        """
        if len(self.chosen) != 1:
            raise OperationRefused("one_only", f"{len(self.chosen)} features are chosen. Choose one.")
        return self.chosen[0]

    def one_polygon(self) -> tuple[MapFeature, LocalFrame, Shape]:
        """Return the only feature chosen, its frame and its valid shape in metres.

        Raises:
            OperationRefused: more than one, no polygon, or its edges cross.
        """
        feature = self.one()
        frame = frame_of([feature])
        return feature, frame, sound_polygon(feature, frame)


def sound_polygon(feature: MapFeature, frame: LocalFrame) -> Shape:
    """Return the valid polygon of a feature, metres in ``frame``.

    Raises:
        OperationRefused: it is no polygon, or its edges cross.
    """
    if feature.geometry["type"] != POLYGON:
        raise OperationRefused(
            "not_a_polygon", f"{title(feature)} is no area. Choose a feature with an outline, such as a parcel."
        )
    shape = shape_of(feature.geometry, frame)
    if not shape.is_valid:
        raise OperationRefused("crosses_itself", f"The outline of {title(feature)} crosses itself. Untangle it first.")
    return shape


def title(feature: MapFeature) -> str:
    """Return the feature's title, shortened to fit a label."""
    text = feature.title
    return text if len(text) <= LONGEST_TITLE else text[: LONGEST_TITLE - 1] + "…"


def titles(features: Sequence[MapFeature]) -> str:
    """Return one title, two joined, or a count of features."""
    if len(features) <= 2:
        return " and ".join(title(one) for one in features)
    nouns = {KINDS[one.kind].noun for one in features}
    noun = nouns.pop() if len(nouns) == 1 else "feature"
    return f"{len(features)} {noun if noun.endswith('s') else noun + 's'}"
