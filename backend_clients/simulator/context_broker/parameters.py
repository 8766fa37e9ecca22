"""The query string of a request, read and refused as Orion does."""

from __future__ import annotations

from collections.abc import Mapping

from starlette.datastructures import QueryParams

from backend_clients.simulator.context_broker.entity import View
from backend_clients.simulator.context_broker.expression import Expression, read_expression
from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.names import FORBIDDEN
from backend_clients.simulator.context_broker.place import read_geo_filter
from backend_clients.simulator.context_broker.refusal import bad_request
from backend_clients.simulator.context_broker.selection import Naming, Page, Selection

MAX_LIMIT = 1000
FREE_TEXT = ("q", "mq", "idPattern", "typePattern", "georel", "geometry", "coords")
FORMS = ("keyValues", "values", "unique")
OPTIONS = {"append", "count", "flowControl", "forcedUpdate", "fullCounters", "noAttrDetail", "normalized", *FORMS}
OPTIONS |= {"overrideMetadata", "skipForwarding", "skipInitialNotification", "upsert"}


class Parameters:
    """One request's parameters; unknown ones are ignored."""

    def __init__(self, query: QueryParams) -> None:
        self._query = query
        for name, value in query.multi_items():
            if not value:
                raise bad_request(f"Empty right-hand-side for URI param /{name}/")
            if name not in FREE_TEXT and not FORBIDDEN.isdisjoint(value):
                raise bad_request("invalid character in URI parameter")
        self.options = frozenset(item for text in query.getlist("options") for item in text.split(","))
        if not self.options <= OPTIONS or len(self.options & set(FORMS)) > 1:
            raise bad_request("Invalid value for URI param /options/")

    def words(self, name: str) -> tuple[str, ...]:
        """Return a comma list; empty if it is not there."""
        text = self._query.get(name, "")
        return tuple(text.split(",")) if text else ()

    def view(self) -> View:
        """Return how answers show entities."""
        form = next((form for form in FORMS if form in self.options), "normalized")
        return View(form, self.words("attrs"), self.words("metadata"))

    def page(self) -> Page:
        """Return which part of a list is wanted."""
        limit_text, offset_text = self._query.get("limit", "20"), self._query.get("offset", "0")
        if not _is_whole(limit_text):
            raise bad_request(f"Bad pagination limit: /{limit_text}/ [must be a positive integer number]")
        if int(limit_text) > MAX_LIMIT:
            raise bad_request(f"Bad pagination limit: /{limit_text}/ [max: {MAX_LIMIT}]")
        if not _is_whole(offset_text):
            raise bad_request(f"Bad pagination offset: /{offset_text}/ [must be a decimal number]")
        order = self.words("orderBy")
        if len({key.removeprefix("!") for key in order}) != len(order):
            raise bad_request("duplicate orderBy token detected")
        return Page(int(limit_text), int(offset_text), "count" in self.options, order)

    def naming(self) -> Naming:
        """Return the ids and types asked for."""
        for one, other in (("id", "idPattern"), ("type", "typePattern")):
            if one in self._query and other in self._query:
                raise bad_request(f"Incompatible parameters: {one}, {other[0].upper()}{other[1:]}")
        get = self._query.get
        return Naming(self.words("id"), self.words("type"), get("idPattern", ""), get("typePattern", ""))

    def selection(self) -> Selection:
        """Return which entities a list is asked of."""
        return selection_of((self.naming(),), self._query)


def selection_of(namings: tuple[Naming, ...], texts: Mapping[str, Json]) -> Selection:
    """Return a selection from the members ``q``, ``mq``, ``georel``, ``geometry`` and ``coords``."""
    if not all(isinstance(texts.get(name, ""), str) for name in FREE_TEXT):
        raise bad_request("expression members must be texts")
    expressions: list[Expression] = []
    for name in ("q", "mq"):
        if texts.get(name):
            expressions.append(read_expression(texts[name], is_metadata=name == "mq"))
    geo = read_geo_filter(texts.get("georel", ""), texts.get("geometry", ""), texts.get("coords", ""))
    return Selection(namings, tuple(expressions), geo)


def _is_whole(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 16
