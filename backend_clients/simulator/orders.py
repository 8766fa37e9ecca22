"""Takes orders from the wire, judges them as a robot must, and answers every one."""

from __future__ import annotations

import math

from msgspec import UNSET, UnsetType
from msgspec.structs import replace

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import mission_hash
from backend_clients.simulator.brain import Brain
from backend_clients.simulator.machine_orders import FRESH_ONLY, MachineOrders, needs
from backend_clients.simulator.mission_run import AT_HOME_M, MOVED_LIMIT_M, MissionRun
from backend_clients.simulator.people_rules import BATTERY_VERY_LOW
from backend_clients.simulator.pilot import DriveState
from backend_clients.simulator.reports import Reporter
from backend_clients.simulator.route import RouteError
from backend_clients.simulator.update import continued
from backend_clients.simulator.verdict import OK, Verdict, accepted, refused

DRIVE_ACK_EVERY_S = 0.5  # refused setpoints come at 10 Hz; one answer in five is enough to explain
MAX_START_DISTANCE_M = 500.0
RUNNING = ("start", "resume", "return_home", "go_to", "tool_retract", "tool_go_to")
"""Orders that take a while."""


class OrderDesk:
    """The only way into the robot's brain.

    Args:
        brain: the brain.
        reporter: stamps the answers.
    """

    def __init__(self, brain: Brain, reporter: Reporter) -> None:
        self._brain, self._reporter = brain, reporter
        self._inside = MachineOrders(brain)
        self._drive_answered_s = -math.inf

    def receive(self, order: down.Order, *, is_retained: bool = False) -> up.Ack | None:
        """Judge and carry out one order; return the answer to send, if there is one."""
        answer = self._judge(order, is_retained=is_retained)
        self._brain.memory.keep_fence(self._brain)
        return answer

    def _judge(self, order: down.Order, *, is_retained: bool) -> up.Ack | None:
        match order:
            case down.Stop():
                return self.stop(order)
            case down.StopReset():
                return self._ack("stop-reset", order.reset_id, self._reset(order, is_retained=is_retained))
            case down.Command():
                return self._ack("command", order.command_id, self._command(order, is_retained=is_retained))
            case down.Drive():
                return self._drive(order, is_retained=is_retained)
            case down.Jog():
                return self._jog(order, is_retained=is_retained)
            case down.OperatorHeartbeat():
                self._pulse(order, is_retained=is_retained)
            case down.Ping() if not is_retained:
                if order.nonce.startswith(down.CONSOLE_NONCE):
                    self._console_heard()
                self._reporter.ping(order.nonce)
            case down.Mission():
                return self._mission(order, is_retained=is_retained)
        return None

    def _console_heard(self) -> None:
        """Count it as a sign of life of the console: only its own pings, and orders proven to be sent just now.

        What is refused, repeated or kept on the way does not count, nor what the STOP gateway or the cloud sends:
        all of that also comes while the console is dead.
        """
        self._brain.link_heard_s = self._brain.clock.mono_s()

    def stop(self, order: down.Stop) -> up.Ack:
        """Stop and latch; valid at any age, from anyone, also retained."""
        brain = self._brain
        is_first = not brain.latch.is_set
        verdict = brain.latch.press(order.stop_id, order.by, order.device, brain.clock.mono_s())
        if verdict.code == "ok":
            if is_first:
                brain.braked_from_m = brain.machine.base.distance_m
            brain.halt(order.stop_id)
            brain.note(
                "safety",
                "STOP",
                order.reason,
                stop_id=order.stop_id,
                by=order.by,
                device=order.device,
                reason=order.reason,
            )
        return self._ack("stop", order.stop_id, verdict)

    def _reset(self, order: down.StopReset, *, is_retained: bool) -> Verdict:
        brain, now = self._brain, self._brain.clock.mono_s()
        known = brain.guard.answer_of(order.reset_id)
        if known is not None:
            return known
        if not brain.guard.can_remember(now):
            return refused("busy")
        verdict = self._judge_leased(order, order.ttl_ms, is_retained=is_retained)
        if verdict.is_accepted:
            verdict = brain.latch.judge_reset(
                order.stop_ids,
                is_standing=brain.machine.is_standing,
                is_hardware_stop=brain.machine.is_hardware_stop,
            )
        if verdict.is_accepted:
            verdict = brain.latch.reset(order.stop_ids)
            self._console_heard()
            brain.note("safety", "STOP reset", order.reason, by=order.by, stop_ids=list(order.stop_ids))
            brain.memory.save_safety(brain)
        if verdict.code != "retained":
            brain.guard.remember(order.reset_id, verdict, now)
        return verdict

    def _command(self, order: down.Command, *, is_retained: bool) -> Verdict:
        brain, now = self._brain, self._brain.clock.mono_s()
        known = brain.guard.answer_of(order.command_id)
        if known is not None:
            return known  # a repeat: the same answer, no second effect
        if not brain.guard.can_remember(now):
            return refused("busy")
        if order.action in FRESH_ONLY:
            verdict = brain.guard.judge_fresh(now, order.challenge, order.ttl_ms / 1000, is_retained=is_retained)
        else:
            verdict = self._judge_leased(order, order.ttl_ms, is_retained=is_retained)
            if verdict.is_accepted:
                brain.operator_heard_s = now
        if verdict.is_accepted and brain.faults.is_rejecting:
            verdict = refused("simulated_reject")
        if verdict.is_accepted:
            verdict = self._carry_out(order)
        if verdict.is_accepted:
            self._console_heard()
        if verdict.code != "retained":
            brain.guard.remember(order.command_id, verdict, now)
        self._note_action(order, verdict)
        return verdict

    def _carry_out(self, order: down.Command) -> Verdict:
        match order.action:
            case "start":
                return self._start(order)
            case "resume":
                return self._resume(order)
            case "pause":
                return self._pause()
            case "abort":
                return self._abort()
            case "return_home":
                return self._return_home()
            case "drive_open":
                return self._drive_open()
            case "drive_close":
                was_open = self._brain.drive is not None
                self._brain.close_drive()
                return OK if was_open else accepted("already_closed", "Driving by hand was not open.")
            case _:
                return self._inside.carry_out(order, self._may_move())

    def _start(self, order: down.Command) -> Verdict:
        brain, run = self._brain, self._brain.run
        verdict = self._may_move()
        if not verdict.is_accepted:
            return verdict
        if run is None:
            return refused("no_mission")
        if not _is_named(order, run):
            return refused("wrong_mission")
        if run.status == "running" or brain.errand:
            return refused("already_running")
        if run.status == "paused" and run.moved_m(brain.place) <= MOVED_LIMIT_M:
            return refused("mission_paused")
        if run.status != "paused" and run.route.has_jump:
            return refused("not_whole")
        s = run.tracker.s_m if run.status == "paused" else 0.0
        if math.dist(brain.place, run.route.point_at(s)) > MAX_START_DISTANCE_M:
            return refused("mission_too_far")
        verdict = self._may_work()
        if verdict.is_accepted:
            brain.begin(is_supervised=order.is_supervised)
        return verdict

    def _resume(self, order: down.Command) -> Verdict:
        brain, run = self._brain, self._brain.run
        verdict = self._may_move()
        if not verdict.is_accepted:
            return verdict
        if run is None or run.status != "paused" or brain.errand:
            return refused("not_paused")
        if not _is_named(order, run):
            return refused("wrong_mission")
        moved_m = run.moved_m(brain.place)
        if moved_m > MOVED_LIMIT_M:
            return refused(
                "moved_while_paused",
                f"It was moved {moved_m:.1f} m since the pause. Drive it back to where it stopped, "
                "or plan the way back with Resume later.",
            )
        verdict = self._may_work()
        if verdict.is_accepted:
            brain.resume(is_supervised=order.is_supervised)
        return verdict

    def _pause(self) -> Verdict:
        brain = self._brain
        if brain.is_auto:
            brain.pause("paused")
            return OK
        if brain.drive is not None:
            brain.close_drive()
            return OK
        if brain.run is not None and brain.run.status == "paused":
            return accepted("already_paused", "The mission is paused already.")
        return refused("nothing_to_pause")

    def _abort(self) -> Verdict:
        brain = self._brain
        if brain.is_auto or (brain.run is not None and brain.run.is_open):
            brain.abort()
            return OK
        return refused("nothing_to_abort")

    def _return_home(self) -> Verdict:
        brain = self._brain
        verdict = self._may_move()
        if not verdict.is_accepted:
            return verdict
        verdict = needs(brain, brain.profile.drive_function)
        if not verdict.is_accepted:
            return verdict
        if brain.errand == "return-home":
            return accepted("already_running", "It is on its way home already.")
        if math.dist(brain.place, brain.home) < AT_HOME_M:
            return refused("already_home")
        if math.dist(brain.place, brain.home) > 10 * MAX_START_DISTANCE_M:
            return refused("mission_too_far", "Home is too far to drive there alone.")
        brain.go_home()
        return OK

    def _drive_open(self) -> Verdict:
        brain = self._brain
        if brain.is_stopped:
            return self._may_move()
        if brain.drive is not None:
            return accepted("already_open", "Driving by hand is open already.")
        verdict = needs(brain, brain.profile.hand_function)
        if not verdict.is_accepted:
            return verdict
        brain.open_drive()
        return OK

    def _may_move(self) -> Verdict:
        brain = self._brain
        if brain.machine.is_hardware_stop:
            return refused("hardware_stop")
        if brain.latch.is_set:
            return refused("stop_latched")
        return refused("manual_open") if brain.drive is not None else OK

    def _may_work(self) -> Verdict:
        brain, machine = self._brain, self._brain.machine
        verdict = needs(brain, brain.profile.work_function)
        if not verdict.is_accepted:
            return verdict
        if machine.soc < BATTERY_VERY_LOW:
            return refused("battery_low")
        if machine.is_rtk_float and brain.profile.needs_rtk:
            return refused("gnss_not_fixed")
        if machine.is_cover_open:
            return refused("tool_interlock")
        if brain.work.waits_for():
            return refused(brain.work.waits_for())
        return refused("person_ahead") if machine.is_way_blocked() else OK

    def _drive(self, order: down.Drive, *, is_retained: bool) -> up.Ack | None:
        brain, now = self._brain, self._brain.clock.mono_s()
        verdict = brain.guard.judge_leased(
            now, order.challenge, 2.0, order.lease_token, order.lease_seq, is_retained=is_retained
        )
        if verdict.is_accepted and brain.is_stopped:
            verdict = self._may_move()
        elif verdict.is_accepted and brain.drive is None:
            verdict = refused("not_in_manual")
        if verdict.is_accepted:
            self._console_heard()
            brain.drive = DriveState(order.v_mps, order.yaw_rate_radps, now)
            brain.last_drive = brain.drive
        return self._answer_setpoint(order.lease_seq, verdict)

    def _jog(self, order: down.Jog, *, is_retained: bool) -> up.Ack | None:
        guard, now = self._brain.guard, self._brain.clock.mono_s()
        verdict = guard.judge_leased(
            now, order.challenge, 2.0, order.lease_token, order.lease_seq, is_retained=is_retained
        )
        if verdict.is_accepted:
            verdict = self._inside.jog(order, self._may_move(), now)
        if verdict.is_accepted:
            self._console_heard()
        return self._answer_setpoint(order.lease_seq, verdict)

    def _answer_setpoint(self, lease_seq: int, verdict: Verdict) -> up.Ack | None:
        """Accepted setpoints are not answered, refused ones not each time."""
        now = self._brain.clock.mono_s()
        if verdict.is_accepted or now - self._drive_answered_s < DRIVE_ACK_EVERY_S:
            return None
        self._drive_answered_s = now
        return self._ack("drive", str(lease_seq), verdict)

    def _pulse(self, order: down.OperatorHeartbeat, *, is_retained: bool) -> None:
        brain, now = self._brain, self._brain.clock.mono_s()
        verdict = brain.guard.judge_pulse(
            now, order.challenge, order.lease_token, order.lease_seq, is_retained=is_retained
        )
        if verdict.is_accepted:
            brain.operator_heard_s = now
            self._console_heard()

    def _mission(self, order: down.Mission, *, is_retained: bool) -> up.Ack:
        proof, order = order.proof, replace(order, proof=UNSET)
        sha256 = mission_hash(order)
        verdict = self._judge_mission(order, sha256, proof, is_retained=is_retained)
        answer = self._ack("mission", order.mission_id, verdict)
        return replace(answer, sha256=sha256) if verdict.is_accepted else answer

    def _judge_mission(
        self, order: down.Mission, sha256: str, proof: down.Proof | UnsetType, *, is_retained: bool
    ) -> Verdict:
        brain, run = self._brain, self._brain.run
        if is_retained:
            return refused("retained")
        if run is not None and run.sha256 == sha256:
            return accepted("already_stored", "The robot has this mission already.")
        if order.continues is not UNSET:
            verdict = self._may_redirect(proof)
            return continued(brain, order, order.continues) if verdict.is_accepted else verdict
        if run is not None and run.is_open:
            return refused("mission_active")
        try:
            brain.load(order)
        except RouteError as error:
            return refused("bad_mission", f"The path of this mission cannot be driven: {error}.")
        return OK

    def _may_redirect(self, proof: down.Proof | UnsetType) -> Verdict:
        """A robot that drives is redirected only by who has control of it, and only just after it was decided."""
        if not self._brain.is_auto:
            return OK
        if isinstance(proof, UnsetType):
            return refused("no_lease", "It drives. Take control to change its mission, or pause it first.")
        now_s = self._brain.clock.mono_s()
        return self._brain.guard.judge_leased(
            now_s, proof.challenge, proof.ttl_ms / 1000, proof.lease_token, proof.lease_seq, is_retained=False
        )

    def _judge_leased(self, order: down.Command | down.StopReset, ttl_ms: int, *, is_retained: bool) -> Verdict:
        return self._brain.guard.judge_leased(
            self._brain.clock.mono_s(),
            order.challenge,
            ttl_ms / 1000,
            order.lease_token,
            order.lease_seq,
            is_retained=is_retained,
        )

    def _note_action(self, order: down.Command, verdict: Verdict) -> None:
        log = self._brain.actions
        if not verdict.is_accepted:
            log.add(order.command_id, order.action, "failed", verdict.text)
        elif order.action in RUNNING:
            log.add(order.command_id, order.action, "running", verdict.text)
        else:
            log.add(order.command_id, order.action, "finished", verdict.text)

    def _ack(self, kind: str, ref: str, verdict: Verdict) -> up.Ack:
        return up.Ack(
            **self._reporter.header(),
            kind=kind,  # type: ignore[arg-type]
            ref=ref,
            outcome="accepted" if verdict.is_accepted else "rejected",
            code=verdict.code,
            text=verdict.text,
            speed_mps=abs(self._brain.machine.base.speed_mps),
        )


def _is_named(order: down.Command, run: MissionRun) -> bool:
    """Say whether the order is for the mission that is here; a console that names no version means any."""
    return order.mission_id == run.mission.mission_id and order.mission_sha256 in (None, run.sha256)
