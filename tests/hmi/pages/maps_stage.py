"""A farm map for the stage: one draft, its log and lock, played as ``docs/protocols/map.md`` says.

Geometry is not computed here: operations do what the screen can show, checks find what a name asks for.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Any, Protocol

from hmi.security.session_info import SessionInfo

Features = dict[str, dict[str, Any]]
Changes = list[dict[str, Any]]
LON, LAT = 11.57549, 48.13742
LOCK = timedelta(minutes=30)
HISTORY = [
    {"key": "crop", "label": "Crop", "before": "Maize", "after": "Sugar beet", "version": 14, "by": "Jonas Weber",
     "published_utc": "2026-05-12T07:30:00+00:00", "note": "New season", "valid_from": "2026-04-09"},
    {"key": "row_spacing_m", "label": "Row spacing", "before": None, "after": 0.45, "version": 13,
     "by": "Pieter de Vries", "published_utc": "2026-03-02T09:00:00+00:00", "note": "", "valid_from": None},
]  # fmt: skip
FORMATS = ("geojson", "kml", "kmz", "shapefile", "isoxml", "gpx", "fiware")


class Sessions(Protocol):
    """Who asks."""

    def of_headers(self, headers: Any) -> SessionInfo | None:
        """Return the person of a request."""


def place(x: float, y: float) -> list[float]:
    """Return longitude and latitude of metres to the right and down, as on a drawing."""
    return [
        round(LON + (x - 400) / (111_320 * math.cos(math.radians(LAT))) / 2, 9),
        round(LAT - (y - 200) / 111_320 / 2, 9),
    ]


def feature(feature_id: str, kind: str, name: str, geometry: str, points: Any, **properties: Any) -> dict[str, Any]:
    """Return a feature drawn in metres."""
    if geometry == "Point":
        coordinates: Any = place(*points)
    elif geometry == "LineString":
        coordinates = [place(*p) for p in points]
    else:
        coordinates = [ring(points), *(ring(hole)[::-1] for hole in properties.pop("holes", []))]
    return {
        "type": "Feature",
        "id": feature_id,
        "properties": {"id": feature_id, "kind": kind, "name": name, **properties},
        "geometry": {"type": geometry, "coordinates": coordinates},
    }


def ring(points: Any) -> list[list[float]]:
    """Return a closed ring that runs counter-clockwise."""
    around = [place(*p) for p in points][::-1]
    return [*around, around[0]]


def circle(x: float, y: float, r: float) -> list[tuple[float, float]]:
    """Return eight corners around a place."""
    return [(x + r * math.cos(i * math.pi / 4), y + r * math.sin(i * math.pi / 4)) for i in range(8)]


def farm() -> Features:
    """Return the farm of the drawing."""
    nord = [(292, 96), (486, 62), (532, 278), (420, 312), (296, 296)]
    west = [(92, 118), (276, 98), (281, 292), (122, 318)]
    hang = [(556, 52), (742, 30), (796, 196), (588, 276)]
    beet: dict[str, Any] = {"crop": "Sugar beet", "status": "BBCH 14", "seeded": "2026-04-09"}
    parts = (
        feature("nordfeld", "parcel", "Nordfeld 12", "Polygon", nord, holes=[circle(446, 214, 9)], **beet,
                row_spacing_m=0.45, row_bearing_deg=11.5, headland_m=3.5),
        feature("westschlag", "parcel", "Westschlag 3", "Polygon", west, crop="Onions", row_bearing_deg=9.0),
        feature("hangacker", "parcel", "Hangacker 5", "Polygon", hang, crop="Carrots"),
        feature("pylon", "obstacle", "pylon", "Polygon", circle(446, 214, 7)),
        feature("road", "road", "Feldweg", "LineString", [(284, 20), (288, 330), (560, 320), (790, 300)], width_m=3.5),
        feature("road-2", "road", "Road to Südbreite 8", "LineString", [(540, 262), (548, 318)], width_m=3.0),
        feature("hedge", "hedge", "", "LineString", [(542, 64), (552, 270)], width_m=5.0),
        feature("home", "home", "Yard", "Point", (330, 345), type="home", heading_deg=90.0),
    )  # fmt: skip
    return {one["id"]: one for one in parts}


def findings(features: Features) -> list[dict[str, Any]]:
    """Return what is wrong: a parcel whose name says so, the end of the second road, a hole near a row."""
    found = []
    for one in features.values():
        if "crossed" in one["properties"]["name"]:
            found.append(
                finding(
                    "crosses",
                    2,
                    one["id"],
                    "Edge crosses itself",
                    "Between corner 3 and 5. Move one of them.",
                    {"label": "Fix", "op": "untangle", "features": [one["id"]], "args": {}},
                )
            )
    if "road-2" in features and "joined" not in features["road-2"]["properties"]:
        snap = {"label": "Snap", "op": "snap_end", "features": ["road-2"], "args": {"to": "road"}}
        found.append(
            finding(
                "gap",
                3,
                "road-2",
                "Road to Südbreite 8 ends 0.8 m short",
                "Robots cannot route across the gap.",
                snap,
                place(548, 318),
            )
        )
    if "nordfeld" in features and len(features["nordfeld"]["geometry"]["coordinates"]) > 1:
        found.append(
            finding(
                "near",
                3,
                "nordfeld",
                "Hole is 1.9 m from row 52",
                "Weeder 07 needs 2.2 m. Swath shrinks.",
                None,
                place(437, 214),
            )
        )
    return found  # fmt: skip


def finding(code: str, level: int, feature_id: str, text: str, advice: str, fix: Any, at: Any = None) -> dict[str, Any]:
    """Return one finding as the console words it."""
    return {
        "code": code, "level": level, "feature_id": feature_id, "other_id": None, "text": text, "advice": advice,
        "at": at, "fix": fix,
    }  # fmt: skip


@dataclass
class Step:
    """One transaction of the log."""

    id: str
    label: str
    changes: Changes
    by: str
    utc: str
    is_undone: bool = False

    def shown(self) -> dict[str, Any]:
        """Return it as the log shows it."""
        shapes = [one["before"] or one["after"] for one in self.changes[:2]]
        names = [shape["properties"]["name"] for shape in shapes if shape["properties"].get("name")]
        return {"id": self.id, "label": self.label, "names": names, "by": self.by, "utc": self.utc,
                "is_undone": self.is_undone}  # fmt: skip


@dataclass
class Draft:
    """A copy of the published map that one person edits."""

    base: int
    features: Features
    user: str
    name: str
    until: datetime
    saved: datetime
    log: list[Step] = field(default_factory=list)


class Refused(Exception):
    """An answer that is none of success."""

    def __init__(self, status: int, code: str, text: str, **more: Any) -> None:
        super().__init__(text)
        self.status = status
        self.body = {"code": code, "text": text, **more}


@dataclass
class StageMap:
    """The map, and what a test wants of it: ``down`` answers nothing, ``slow_s`` answers late."""

    features: Features = field(default_factory=farm)
    version: int = 14
    note: str = "Spring"
    draft: Draft | None = None
    versions: list[dict[str, Any]] = field(default_factory=list)
    imported: Features = field(default_factory=dict)
    is_down: bool = False
    slow_s: float = 0.0
    asked: list[dict[str, Any]] = field(default_factory=list)
    proposals: list[dict[str, Any]] = field(default_factory=list)

    def propose(self, session: SessionInfo, more: list[str], body: dict[str, Any]) -> Any:
        """Answer a request about changes from the cloud."""
        if not more:
            taken = {one.label for one in self.draft.log if not one.is_undone} if self.draft else set[str]()
            by = {True: session.user_name, False: ""}
            return {
                "proposals": [
                    {**one, "in_draft_by": by[f"From the cloud: {one['name']}" in taken]} for one in self.proposals
                ]
            }
        one = next(one for one in self.proposals if one["id"] == more[0])
        if more[1] == "refuse":
            self.proposals.remove(one)
            return {}
        change = {"id": one["id"], "before": self.mine(session).features.get(one["id"]), "after": one["after"]}
        return self.change(session, body["id"], f"From the cloud: {one['name']}", [change])

    def published(self, session: SessionInfo) -> dict[str, Any]:
        """Return what ``GET /map`` answers."""
        draft = self.draft and {**self.state(session), "features": collection(self.draft.features)}
        return {
            "version": self.version, "published_utc": "2026-05-12T07:30:00+00:00", "by": "Jonas Weber",
            "note": self.note, "features": collection(self.features), "draft": draft,
        }  # fmt: skip

    def state(self, session: SessionInfo) -> dict[str, Any]:
        """Return the draft without its features."""
        draft = self.held()
        done = [one for one in draft.log if not one.is_undone]
        undone = [one for one in draft.log if one.is_undone]
        return {
            "base_version": draft.base, "saved_utc": draft.saved.isoformat(),
            "editor": {"user": draft.user, "name": draft.name}, "until_utc": draft.until.isoformat(),
            "left_s": max((draft.until - datetime.now(UTC)).total_seconds(), 0.0),
            "is_mine": draft.user == session.user_id, "undo": done[-1].label if done else None,
            "redo": undone[0].label if undone else None,
            "undo_id": done[-1].id if done else None, "redo_id": undone[0].id if undone else None,
            "log": [one.shown() for one in draft.log[::-1]],
        }  # fmt: skip

    def held(self) -> Draft:
        """Return the draft there is."""
        if self.draft is None:
            raise Refused(404, "not_found", "There is no draft.")
        return self.draft

    def mine(self, session: SessionInfo) -> Draft:
        """Return the draft if this person edits it."""
        draft = self.held()
        if draft.user != session.user_id and draft.until > datetime.now(UTC):
            raise self.locked()
        draft.user, draft.name, draft.until = session.user_id, session.user_name, datetime.now(UTC) + LOCK
        return draft

    def locked(self) -> Refused:
        """Return the refusal that names who edits."""
        draft = self.held()
        return Refused(423, "locked", f"{draft.name} edits this map.", by=draft.name, until_utc=draft.until.isoformat())

    def open(self, session: SessionInfo, *, is_taking: bool) -> dict[str, Any]:
        """Begin, go on with, or take the draft."""
        now = datetime.now(UTC)
        if self.draft is None:
            copied = copy.deepcopy(self.features)
            self.draft = Draft(self.version, copied, session.user_id, session.user_name, now + LOCK, now)
        elif is_taking:
            self.draft.until = now
        draft = self.mine(session)
        return {**self.state(session), "features": collection(draft.features)}

    def change(self, session: SessionInfo, ref: str, label: str, changes: Changes) -> dict[str, Any]:
        """Take a transaction once, if what it saw is what is there."""
        draft = self.mine(session)
        if any(one.id == ref for one in draft.log):
            return {"draft": self.state(session), "changes": changes}
        if any(draft.features.get(one["id"]) != one["before"] for one in changes):
            raise Refused(409, "changed", "Somebody changed it meanwhile.")
        draft.log = [one for one in draft.log if not one.is_undone]
        draft.saved = datetime.now(UTC)
        draft.log.append(Step(ref, label, changes, session.user_name, draft.saved.isoformat()))
        self.apply(changes)
        return {"draft": self.state(session), "changes": changes}

    def apply(self, changes: Changes) -> None:
        """Put changes into the draft."""
        for one in changes:
            if one["after"] is None:
                self.held().features.pop(one["id"], None)
            else:
                self.held().features[one["id"]] = one["after"]

    def walk(self, session: SessionInfo, *, is_back: bool) -> dict[str, Any]:
        """Undo or redo one step."""
        draft = self.mine(session)
        steps = [one for one in draft.log if one.is_undone != is_back]
        if not steps:
            raise Refused(409, "nothing", "There is nothing to undo." if is_back else "There is nothing to redo.")
        step = steps[-1] if is_back else steps[0]
        step.is_undone = is_back
        changes = [back(one) for one in step.changes[::-1]] if is_back else step.changes
        self.apply(changes)
        return {"draft": self.state(session), "changes": changes}

    def operate(self, session: SessionInfo, body: dict[str, Any]) -> dict[str, Any]:
        """Play an operation."""
        draft = self.mine(session)
        op, ids, args = body["op"], body["features"], body["args"]
        first = draft.features[ids[0]]
        after = copy.deepcopy(first)
        name = first["properties"]["name"]
        changes = [{"id": ids[0], "before": first, "after": after}]
        if op == "untangle":
            after["properties"]["name"] = name.replace(" crossed", "")
        elif op == "snap_end":
            after["properties"]["joined"] = args["to"]
        elif op in ("buffer", "simplify", "straighten_all", "turn"):
            after["properties"]["done"] = [op, args]
        elif op == "add_hole":
            after["geometry"]["coordinates"].append(args["ring"])
        elif op == "merge":
            changes += [{"id": one, "before": draft.features[one], "after": None} for one in ids[1:]]
        elif op == "split":
            other = {**copy.deepcopy(first), "id": f"{ids[0]}-2"}
            other["properties"] |= {"id": other["id"], "name": f"{name} b"}
            changes.append({"id": other["id"], "before": None, "after": other})
        else:
            raise Refused(422, "not_possible", "This cannot be done here.")
        labels = {"untangle": "Edge untangled", "snap_end": "Road end joined", "add_hole": "Hole added",
                  "buffer": "Shape grown", "simplify": "Shape simplified", "turn": "Shape turned",
                  "straighten_all": "Edges straightened", "merge": "Parcels merged",
                  "split": f"{name} split"}  # fmt: skip
        return self.change(session, body["id"], labels[op], changes)

    def preview(self, body: dict[str, Any]) -> dict[str, Any]:
        """Play what an operation would do: a shape that is the same, and numbers."""
        after = self.held().features[body["features"][0]]
        if body["args"].get("distance_m", 0) < -100:
            text = "Nothing would be left. Choose less, or delete it."
            return {"label": "", "changes": [], "effect": None, "refused": {"code": "vanishes", "text": text}}
        effect = {"corners_before": 180, "corners_after": 42, "area_before_m2": 12_200.0, "area_after_m2": 11_400.0,
                  "off_m": 0.08, "pieces": 1}  # fmt: skip
        return {
            "label": "Tried", "changes": [{"id": after["id"], "after": after}], "effect": effect, "refused": None,
        }  # fmt: skip

    def publish(self, session: SessionInfo, note: str, *, is_shrinking_ok: bool) -> dict[str, Any]:
        """Make the draft the next version."""
        draft = self.mine(session)
        blocking = [one for one in findings(draft.features) if one["level"] == 2]
        if blocking:
            raise Refused(409, "blocked", "Fix 1 blocking check first.", findings=blocking)
        if len(draft.features) < len(self.features) / 2 and not is_shrinking_ok:
            raise Refused(409, "shrinks", f"{len(draft.features)} of {len(self.features)} shapes would stay.")
        self.features, self.version, self.note, self.draft = draft.features, self.version + 1, note, None
        return {"version": self.version}

    def difference(self) -> dict[str, Any]:
        """Return what the draft changes."""
        draft = self.held()
        rows = []
        for one in sorted({*self.features, *draft.features}):
            was, now = self.features.get(one), draft.features.get(one)
            if was == now:
                continue
            what = "added" if was is None else "removed" if now is None else "changed"
            shown = (now or was or {})["properties"]
            rows.append({"id": one, "name": shown["name"], "kind": shown["kind"], "what": what, "text": what})
        return {"base_version": draft.base, "differences": rows}

    def read(self, name: str, size: int) -> dict[str, Any]:
        """Play the reading of a file: eight shapes, two of them without coordinates."""
        if name.endswith(".txt"):
            raise Refused(422, "unreadable", f"{name} is no map file.", advice="Save it as GeoJSON and try again.")
        items = []
        if name.startswith("district"):
            return many_shapes()
        for n in range(6):
            corners = [(600 + 40 * n, 300), (630 + 40 * n, 300), (630 + 40 * n, 340), (600 + 40 * n, 340)]
            one = feature(f"new-{n}", "parcel", f"Schlag {n + 1}", "Polygon", corners)
            self.imported[str(n)] = one
            items.append({
                "n": n, "name": f"Schlag {n + 1}", "kind": "parcel", "kinds": ["parcel", "obstacle", "no-go"],
                "vertices": 4, "area_m2": 300.0, "geometry": one["geometry"], "properties": {"size": size},
                "problems": ["It overlaps Hangacker 5 by 14 m²."] if n == 5 else [],
            })  # fmt: skip
        skipped = [{"which": f"Shape {n}", "why": "no coordinates", "mend": "Draw it again in the program it is from."}
                   for n in (7, 8)]  # fmt: skip
        return {"id": "import-1", "format": "GeoJSON", "crs": "WGS84", "items": items, "skipped": skipped}

    def take(self, session: SessionInfo, body: dict[str, Any]) -> dict[str, Any]:
        """Put chosen shapes of the import into the draft."""
        changes = []
        for n in body["items"]:
            one = copy.deepcopy(self.imported[str(n)])
            one["properties"]["kind"] = body["kinds"][str(n)]
            changes.append({"id": one["id"], "before": None, "after": one})
        return self.change(session, body["id"], f"Imported {len(changes)} shapes", changes)


def many_shapes() -> dict[str, Any]:
    """Return a file of 5,000 shapes; every tenth is no parcel."""
    items = [{
        "n": n, "name": f"Perceel {n}", "kind": "road" if n % 10 == 0 else "parcel", "kinds": ["parcel", "road"],
        "vertices": 60, "area_m2": 9000.0, "problems": [],
    } for n in range(5000)]  # fmt: skip
    return {"id": "import-2", "format": "GeoJSON", "crs": "WGS84", "items": items, "skipped": []}


def back(change: dict[str, Any]) -> dict[str, Any]:
    """Return a change the other way round."""
    return {"id": change["id"], "before": change["after"], "after": change["before"]}


def collection(features: Features) -> dict[str, Any]:
    """Return a FeatureCollection."""
    return {"type": "FeatureCollection", "features": list(features.values())}


class MapStage:
    """Holds the map of the scene that is played."""

    def __init__(self) -> None:
        self.map = StageMap()

    def set(self, wish: dict[str, Any]) -> None:
        """Begin anew, or change what a test asks for."""
        if wish.get("anew"):
            self.map = StageMap()
        if wish.get("is_empty"):
            self.map.features, self.map.version = {}, 0
        if "is_down" in wish:
            self.map.is_down = wish["is_down"]
        if "proposals" in wish:
            self.map.proposals = wish["proposals"]
        if "slow_s" in wish:
            self.map.slow_s = wish["slow_s"]
        if "rename" in wish:
            features = self.map.draft.features if self.map.draft and wish.get("in_draft") else self.map.features
            for feature_id, name in wish["rename"].items():
                features[feature_id] = copy.deepcopy(features[feature_id])
                features[feature_id]["properties"]["name"] = name
        if "editor" in wish:
            now = datetime.now(UTC)
            draft = self.map.draft or Draft(self.map.version, copy.deepcopy(self.map.features), "", "", now, now)
            draft.user, draft.name, draft.until = wish["editor"], wish["name"], now + LOCK
            self.map.draft = draft

    def heard(self) -> dict[str, Any]:
        """Return what reached the map, and what it is now."""
        draft = self.map.draft
        return {
            "asked": self.map.asked, "version": self.map.version, "note": self.map.note,
            "published": self.map.features, "draft": draft and draft.features,
            "labels": draft and [one.label for one in draft.log if not one.is_undone],
        }  # fmt: skip
