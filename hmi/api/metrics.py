"""Figures for Prometheus: counters of orders, and whatever the parts count by themselves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from prometheus_client import CollectorRegistry, Counter, Histogram, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.exposition import CONTENT_TYPE_PLAIN_0_0_4
from prometheus_client.registry import Collector
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from hmi.commands.ledger import CommandResult, Ticket
from hmi.domain.command import Outcome

PREFIX = "headland_"
LATENCY_S = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 5.0)
Labelled = Mapping[str, float] | Mapping[tuple[str, ...], float]


@dataclass(frozen=True, slots=True)
class Gauge:
    """A value read when somebody scrapes; ``label`` names the key of ``read``, or its parts, of a mapping."""

    name: str
    help: str
    read: Callable[[], float | Labelled]
    label: str | tuple[str, ...] = ""
    is_counter: bool = False


class _Gauges(Collector):
    def __init__(self, gauges: list[Gauge]) -> None:
        self._gauges = gauges

    def collect(self) -> Iterable[Metric]:
        """Read every value now."""
        for gauge in self._gauges:
            kind = CounterMetricFamily if gauge.is_counter else GaugeMetricFamily
            labels = [gauge.label] if isinstance(gauge.label, str) else list(gauge.label)
            family = kind(PREFIX + gauge.name, gauge.help, labels=labels if gauge.label else None)
            value = gauge.read()
            pairs: Iterable[tuple[str | tuple[str, ...], float]]
            pairs = value.items() if isinstance(value, Mapping) else [((), value)]
            for key, number in pairs:
                family.add_metric([key] if isinstance(key, str) else list(key), number)
            yield family


class ConsoleMetrics:
    """The console's registry of figures; give ``observe`` to ``OrderLedger.when_settled``."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        self._orders = Counter(
            f"{PREFIX}orders", "Orders by what was asked and what came of it.", ["action", "outcome"],
            registry=self._registry,
        )  # fmt: skip
        self._latency = Histogram(
            f"{PREFIX}order_answer_seconds", "From sending an order to the robot's answer.", ["action"],
            buckets=LATENCY_S, registry=self._registry,
        )  # fmt: skip
        self._gauges: list[Gauge] = []
        self._registry.register(_Gauges(self._gauges))

    def add(self, *gauges: Gauge) -> None:
        """Show further values."""
        self._gauges.extend(gauges)

    def observe(self, ticket: Ticket, result: CommandResult) -> None:
        """Count one outcome."""
        if result.outcome is Outcome.PENDING:
            return
        self._orders.labels(ticket.what, result.outcome.value).inc()
        if result.ms is not None:
            self._latency.labels(ticket.what).observe(result.ms / 1000)

    def page(self) -> bytes:
        """Return all figures in the text format of Prometheus."""
        return generate_latest(self._registry)

    def route(self) -> Route:
        """Return the route ``/metrics``, which belongs on the root of the site."""

        async def metrics(_request: Request) -> Response:
            return Response(self.page(), media_type=CONTENT_TYPE_PLAIN_0_0_4)

        return Route("/metrics", metrics, name="metrics")
