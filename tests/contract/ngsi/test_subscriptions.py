"""The client keeps subscriptions, and a broker notifies of changes."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest

from backend_clients.ngsi import entity as make
from backend_clients.ngsi import errors
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.identifier import ref_for
from backend_clients.ngsi.intake import Intake, Verdict
from backend_clients.ngsi.subscription import Wanted
from backend_clients.ngsi.subscriptions import Subscriptions
from tests.contract.ngsi.receiver import Receiver

REF = ref_for("AgriRobot", "weeder-01")


def now() -> datetime:
    return datetime.now(UTC)


def wanted(receiver: Receiver) -> Wanted:
    return Wanted("robots", receiver.url, ("AgriRobot",), watch=("speed",))


async def test_a_change_is_notified_with_its_time_and_nothing_of_before(
    client: NgsiClient, subscriptions: Subscriptions, receiver: Receiver
) -> None:
    await client.create(Entity(ref=REF, attributes={"speed": make.number(1), "note": make.text("a=b")}))
    kept = await subscriptions.ensure(wanted(receiver), now())
    await client.patch(REF, {"note": make.text("c=d")})
    await client.patch(REF, {"speed": make.number(1)})
    await client.patch(REF, {"speed": make.number(2)})
    came = await receiver.next()
    assert came.subscription_id == kept.id
    assert came.service == client.connection.broker.tenant.service
    assert came.path == "/farm"
    assert came.correlator
    (entity,) = came.entities
    assert (entity.ref, entity.value("speed"), entity.value("note")) == (REF, 2, "c=d")
    assert receiver.waiting() == 0
    intake = Intake()
    assert intake.judge(entity, now()) is Verdict.NEW
    assert intake.judge(entity, now()) is Verdict.REPEAT


async def test_making_and_deleting_are_notified(
    client: NgsiClient, subscriptions: Subscriptions, receiver: Receiver
) -> None:
    await subscriptions.ensure(wanted(receiver), now())
    await client.create(Entity(ref=REF, attributes={"speed": make.number(1)}))
    intake = Intake()
    assert intake.judge((await receiver.next()).entities[0], now()) is Verdict.NEW
    await client.delete(REF)
    assert intake.judge((await receiver.next()).entities[0], now()) is Verdict.GONE


async def test_a_subscription_is_made_once_and_then_adopted(subscriptions: Subscriptions, receiver: Receiver) -> None:
    made = await subscriptions.ensure(wanted(receiver), now())
    again = await subscriptions.ensure(wanted(receiver), now())
    assert (made.how, again.how, again.id) == ("made", "adopted", made.id)
    assert len([item async for item in subscriptions.mine()]) == 1


async def test_a_subscription_is_renewed_in_the_second_half_of_its_life(
    subscriptions: Subscriptions, receiver: Receiver
) -> None:
    made = await subscriptions.ensure(wanted(receiver), now())
    later = now() + timedelta(hours=13)
    renewed = await subscriptions.ensure(wanted(receiver), later)
    assert (renewed.how, renewed.id) == ("renewed", made.id)
    expires = (await subscriptions.get(made.id)).expires
    assert expires is not None
    assert abs(expires - (later + timedelta(hours=24))) < timedelta(seconds=1)


async def test_a_subscription_that_asks_for_something_else_is_mended(
    subscriptions: Subscriptions, receiver: Receiver
) -> None:
    made = await subscriptions.ensure(wanted(receiver), now())
    other = await subscriptions.ensure(replace(wanted(receiver), watch=()), now())
    assert (other.how, other.id) == ("mended", made.id)


async def test_a_subscription_deleted_behind_our_back_is_made_anew(
    client: NgsiClient, subscriptions: Subscriptions, receiver: Receiver
) -> None:
    made = await subscriptions.ensure(wanted(receiver), now())
    await Subscriptions(client.connection, "contract").clean_up(keep=())
    with pytest.raises(errors.NotFound):
        await subscriptions.get(made.id)
    assert (await subscriptions.ensure(wanted(receiver), now())).how == "made"


@pytest.mark.slow
async def test_cleaning_up_leaves_what_is_kept_and_what_is_somebody_elses(
    client: NgsiClient, subscriptions: Subscriptions, receiver: Receiver
) -> None:
    others = Subscriptions(client.connection, "another-console")
    theirs = await others.ensure(wanted(receiver), now())
    kept = await subscriptions.ensure(wanted(receiver), now())
    gone = await subscriptions.ensure(replace(wanted(receiver), key="old"), now())
    assert await subscriptions.clean_up(keep={"robots"}) == [gone.id]
    assert {item.id async for item in subscriptions.all()} == {theirs.id, kept.id}
    await others.clean_up(keep=())


async def test_how_delivery_goes_is_told(client: NgsiClient, subscriptions: Subscriptions, receiver: Receiver) -> None:
    kept = await subscriptions.ensure(wanted(receiver), now())
    assert (await subscriptions.get(kept.id)).times_sent == 0
    await client.create(Entity(ref=REF, attributes={"speed": make.number(1)}))
    await receiver.next()
    told = await subscriptions.get(kept.id)
    assert (told.status, told.times_sent) == ("active", 1)
    assert told.delivers()
