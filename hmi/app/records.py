"""Everything that is kept and everybody who may sign in, built from the settings."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from hmi.security.accounts import Accounts
from hmi.security.enrolment import Enrolment
from hmi.security.passwords import Passwords
from hmi.security.sessions import Sessions
from hmi.security.sign_in import SignIn
from hmi.security.stop_tokens import StopTokens
from hmi.security.walls import WallScreens
from hmi.store.audit import Audit
from hmi.store.base_maps import BaseMapRecords
from hmi.store.camera_sources import CameraSources
from hmi.store.checklists import Checklists
from hmi.store.counters import Counters
from hmi.store.database import Database
from hmi.store.devices import Devices
from hmi.store.duty import Duties
from hmi.store.farms import Farms
from hmi.store.features import Features
from hmi.store.fleet_groups import FleetGroups
from hmi.store.history import History
from hmi.store.maps import Maps
from hmi.store.missions import Missions
from hmi.store.pictures import PictureRecords
from hmi.store.recorder import Recorder
from hmi.store.robots import Robots
from hmi.store.state_times import StateRecords
from hmi.store.stop_list import StopList
from hmi.store.templates import Templates
from hmi.store.thinning import Thinning
from hmi.store.users import Users
from hmi.store.walls import Walls

if TYPE_CHECKING:
    from hmi.clock import Clock
    from hmi.settings import Settings


class Records:
    """The database, its repositories, and accounts and sessions on top of them.

    Args:
        is_registered: says whether a robot's samples are worth keeping.
    """

    def __init__(self, settings: Settings, clock: Clock, is_registered: Callable[[str], bool]) -> None:
        farm = settings.farm_id
        self._settings, self._clock = settings, clock
        self.database = Database(settings.database)
        self.farms = Farms(self.database, clock)
        self.stop_list = StopList(self.database, farm, settings.data / "stop")
        self.users = Users(self.database, clock)
        self.devices = Devices(self.database, clock, self.stop_list)
        self.robots = Robots(self.database, farm, clock, self.stop_list)
        self.audit = Audit(self.database, clock, settings.data / "audit-spill.jsonl")
        self.recorder = Recorder(self.database, farm, clock, is_registered)
        self.history = History(self.database, farm)
        self.state_times = StateRecords(self.database, farm)
        self.counters = Counters(self.database, farm)
        self.features = Features(self.database, clock)
        self.maps = Maps(self.database, clock)
        self.base_maps = BaseMapRecords(self.database)
        self.pictures = PictureRecords(self.database)
        self.camera_sources = CameraSources(self.database, farm)
        self.missions = Missions(self.database, clock)
        self.checklists = Checklists(self.database, clock)
        self.templates = Templates(self.database, clock)
        self.fleet_groups = FleetGroups(self.database, clock)
        self.duties = Duties(self.database, farm, clock)
        self.thinning = Thinning(self.database)
        self.passwords = Passwords(settings.secret)
        self.tokens = StopTokens(settings.secret, self.devices.is_revoked)
        self.sessions = Sessions(self.database, clock, farm, settings.session_hours * 3600)
        self.accounts = Accounts(
            self.database, farm, self.users, self.sessions, self.passwords, self.stop_list, self.audit.append
        )
        self.sign_in = SignIn(
            self.database,
            clock,
            farm,
            self.users,
            self.devices,
            self.sessions,
            self.passwords,
            self.tokens,
            self.audit.append,
        )
        self.walls = WallScreens(
            self.database, Walls(self.database, clock), self.sessions, farm, self.audit.append, self.stop_list
        )
        self.enrolment = Enrolment(self.database, self.devices, self.sessions, self.tokens, self.audit.append)

    def open(self) -> None:
        """Migrate and load what must be in memory; blocks, before the event loop serves anybody.

        Raises:
            StoreError: the database cannot be used.
        """
        self.database.migrate()
        self.farms.ensure(self._settings.farm_id, self._settings.farm_name)
        self.robots.load()
        self.devices.load()
        self.checklists.load()
        self.duties.load()
        self.stop_list.export()

    def start(self) -> None:
        """Start the writers."""
        self.audit.start()
        self.recorder.start()

    def close(self) -> None:
        """Write what is queued, then close; blocks for about two seconds at most."""
        self.recorder.close()
        self.audit.close()
        self.passwords.close()
        self.database.close()
