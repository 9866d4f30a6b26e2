"""Trials of the motions between bodies, each judged on the true state over many seeds.

A trial starts a whole robot (:func:`mobius.assemble.build_sim_stack`) from a drawn
configuration, asks the mode machine for what the trial is named after, and watches. It
succeeds when the true robot is in the right stance within the time limit, without a fall and
recovery on the way where none is part of the trial, holds there under the mode's own policy,
and no driving servo gave more than its torque-speed line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mobius.assemble import MOTION_OF, build_sim_stack
from mobius.control.peers import controller_of
from mobius.control.policy import load_policy, shipped_policy
from mobius.errors import InvalidInput, UnknownName
from mobius.evaluate.jobs import Progress, run_jobs
from mobius.evaluate.trial_report import Motions, TrialRun, summarise
from mobius.evaluate.trial_source import Asks
from mobius.evaluate.trial_start import draw_start
from mobius.evaluate.trial_watch import Watch
from mobius.geometry import wrap_angle
from mobius.modes import Event, Posture, load_motion, motion_names
from mobius.modes.motions import Motion
from mobius.robot import TICK
from mobius.stack import READ_EVERY, Sample, Stack
from mobius.types import Mode

Array = NDArray[np.float64]

LINE_SLACK = 1e-6
"""Rounding [N m] on the servos' torque-speed line."""
LANDED_S = 1.0
"""By then a robot that was dropped is on the floor [s]."""
FULL_TURN = float(np.radians(40.0))
"""A roll's rotation may differ from 360 deg by this: the stances before and after are judged
by themselves, so it only tells one turn from none and from two."""


@dataclass(frozen=True)
class Trial:
    """What one trial asks and wants."""

    name: str
    pose: str
    """Keyframe it starts in, ``fall``, or ``stance``: that of the crawl policy."""
    asks: Mode | None
    """Mode that is asked for after a second; None where the robot starts fallen."""
    ends: Mode
    """Mode it must be in at the end."""
    limit_s: float
    """From the begin of the motion, or the start, to the stance [s]."""
    hold_s: float = 2.0
    """How long it must hold there [s]."""
    modes: tuple[str, ...] = ("crawl",)
    needs: tuple[str, ...] = ()
    """Motions it needs."""
    times: int = 1
    """How often the mode is asked for."""

    @property
    def stance(self) -> Posture:
        """Where it must end."""
        return Posture.STANDING if self.ends is Mode.BIPED else Posture.CRAWLING


_BOTH = ("crawl", "biped")
TRIALS: dict[str, Trial] = {
    t.name: t
    for t in (
        Trial("prone_to_crawl", "prone", None, Mode.CRAWL, 6.0, needs=("prone_to_crawl",)),
        Trial("stand_to_crawl", "stand", Mode.CRAWL, Mode.CRAWL, 6.0, modes=_BOTH),
        Trial("crawl_to_stand", "crawl", Mode.BIPED, Mode.BIPED, 6.0, modes=_BOTH),
        Trial(
            "supine_recovery",
            "supine",
            None,
            Mode.BIPED,
            10.0,
            modes=("biped",),
            needs=("supine_recovery",),
        ),
        Trial(
            "head_recovery",
            "on_head",
            None,
            Mode.CRAWL,
            10.0,
            needs=("head_recovery", "prone_to_crawl"),
        ),
        Trial("any_fall", "fall", None, Mode.CRAWL, 15.0, needs=("supine_to_crawl",)),
        Trial("roll", "crawl", Mode.ROLL, Mode.CRAWL, 10.0, 1.0, modes=("crawl", "roll")),
        Trial("five_rolls", "crawl", Mode.ROLL, Mode.CRAWL, 75.0, 1.0, ("crawl", "roll"), times=5),
        Trial("push_ups", "crawl", Mode.PUSH_UPS, Mode.CRAWL, 120.0, modes=("crawl", "push_ups")),
        Trial("gather_stand", "stance", Mode.BIPED, Mode.BIPED, 6.0, modes=_BOTH),
        Trial("gather_roll", "stance", Mode.ROLL, Mode.CRAWL, 11.5, 1.0, modes=("crawl", "roll")),
    )
}
"""Trials by name."""
HEADING_WITHIN = float(np.radians(15.0))
"""Five rolls must keep their heading to this [rad]."""
PUSH_UPS = 20
"""In a row."""


def needed(trial: Trial) -> set[str]:
    """Names of the motions a trial cannot do without."""
    serves = {mode for mode in trial.modes if mode in ("roll", "push_ups")}
    if {"crawl", "biped"} <= set(trial.modes):
        serves |= {MOTION_OF[Mode.STAND_UP], MOTION_OF[Mode.LIE_DOWN]}
    return {*trial.needs, *serves}


def run_trial(
    job: tuple[str, int],
    *,
    motions: Mapping[str, Motion] | None = None,
    policy: Path | None = None,
) -> TrialRun:
    """One seed of one trial.

    Args:
        job: Name of the trial, seed.
        motions: By name; the shipped ones if not given.
        policy: ONNX file that crawls; the shipped one if not given.
    """
    trial, seed = TRIALS[job[0]], job[1]
    body = "biped" if trial.pose == "stand" or trial.ends is Mode.BIPED else "crawl"
    crawls = policy or shipped_policy("crawl")
    own = load_policy(crawls).default if trial.pose == "stance" else None
    drawn = draw_start("crawl" if own is not None else trial.pose, body, seed, joints=own)
    first = {
        "crawl": Mode.CRAWL, "stance": Mode.CRAWL, "stand": Mode.BIPED, "fall": Mode.CRAWL,
    }.get(trial.pose, Mode.RECOVER)  # fmt: skip
    start = replace(drawn.start, mode=first)
    stack, robot = build_sim_stack(
        drawn.model, start, policy={"crawl": crawls}, modes=trial.modes, motions=motions
    )
    watch = Watch(robot, drawn)
    return _Course(trial, seed, stack, watch).run()


class _Course:
    """One run of one trial, from its first tick to its verdict."""

    def __init__(self, trial: Trial, seed: int, stack: Stack, watch: Watch) -> None:
        self.trial, self.seed, self.stack, self.watch = trial, seed, stack, watch
        self.asks = Asks(trial.asks, trial.ends, first=stack.machine.mode, times=trial.times)
        self.began: float | None = 0.0 if trial.asks is None else None
        self.reached: float | None = None
        self.heading = watch.heading
        self.failed = ""
        self.rolls: list[tuple[float, float, float]] = []
        """(rotation [rad], way [m], time [s]) of each roll."""
        self.turns: list[float] = []
        """How far off its first heading the robot was after each roll [rad]."""
        self.away = (0.0, 0.0)
        self.place, self.energy = watch.truth.p_OB.copy(), 0.0
        self._mode = stack.machine.mode
        self._lands = LANDED_S if trial.pose == "fall" else 0.0

    def run(self) -> TrialRun:
        """Turn the stack until the verdict."""
        while not self.failed and not self._held():
            if self.stack.tick % READ_EVERY == 0:
                self.watch.look()
            sample = self.stack.turn(self.asks)
            if sample is not None:
                self._judge(sample)
        return self._verdict()

    def _held(self) -> bool:
        return self.reached is not None and self.watch.now - self.reached >= self.trial.hold_s

    def _judge(self, sample: Sample) -> None:
        """One 60 Hz turn: changes of mode, time limit, stance and falls."""
        trial, watch, mode = self.trial, self.watch, sample.command.mode
        now = sample.tick * TICK
        if mode is not self._mode:
            self._change(mode, now, sample)
        self._mode = mode
        if mode is Mode.STOP:
            self._fail(self.stack.machine.notice)
        if self.began is None:
            if now > 12.0:
                self._fail(f"'{trial.asks}' did not begin: {self.stack.machine.notice}")
        elif self.reached is None:
            ended = mode is trial.ends and self.asks.over and now >= self._lands
            if ended and watch.is_in(trial.stance):
                self.reached = now
                self.away = watch.belief_error(sample.belief)
                self.energy = sample.energy - self.energy
            elif now - self.began > trial.limit_s:
                self._fail(f"not there after {trial.limit_s:g} s, but {watch.posture()} in {mode}")
        elif mode is not trial.ends or watch.fell_from(trial.stance):
            self._fail(f"did not hold: {watch.posture()} in {mode}")

    def _change(self, mode: Mode, now: float, sample: Sample) -> None:
        """The mode machine went on."""
        self.watch.gathers = mode is Mode.GATHER
        if mode is Mode.GATHER:
            self.watch.gathering.begin()
        elif self._mode is Mode.GATHER and mode not in (Mode.RECOVER, Mode.STOP):
            self.watch.gathering.done += 1
        self.asks.entered(mode, self._mode, now)
        if self.began is None and mode not in (Mode.CRAWL, Mode.BIPED):
            self.began, self.energy = now, sample.energy
            self.heading, self.place = self.watch.heading, self.watch.truth.p_OB.copy()
        if mode is Mode.ROLL:
            self.watch.start_roll()
        if self._mode is Mode.ROLL:
            w = self.watch
            self.rolls.append((w.rotation, w.roll_way, w.roll_s))
            self.turns.append(float(wrap_angle(w.heading - self.heading)))
        if mode is Mode.RECOVER and self.trial.asks is not None:
            self._fail(self.stack.machine.events[-1].why)

    def _fail(self, why: str) -> None:
        self.failed = self.failed or why

    def _verdict(self) -> TrialRun:
        trial, watch = self.trial, self.watch
        turn = max(self.turns, key=abs, default=0.0)
        rolls = trial.asks is Mode.ROLL
        way = float(np.linalg.norm(watch.truth.p_OB[:2] - self.place[:2]))
        if rolls:
            if len(self.rolls) < trial.times:
                self._fail(f"{len(self.rolls)} of {trial.times} rolls")
            if any(abs(r[0] + 2 * np.pi) > FULL_TURN for r in self.rolls):
                self._fail(f"turned by {[round(np.degrees(r[0])) for r in self.rolls]} deg")
            if trial.times > 1 and abs(turn) > HEADING_WITHIN:
                self._fail(f"heading off by {np.degrees(turn):.0f} deg")
        if trial.name == "push_ups" and watch.push_ups.count < PUSH_UPS:
            self._fail(f"{watch.push_ups.count} push-ups")
        if watch.over_line > LINE_SLACK:
            self._fail(f"a servo gave {watch.over_line:.2g} N m beyond its line")
        seconds = None
        if self.reached is not None and self.began is not None:
            seconds = self.reached - self.began
        speed = sum(r[1] for r in self.rolls) / max(sum(r[2] for r in self.rolls), 1e-9)
        return TrialRun(
            trial=trial.name,
            seed=self.seed,
            success=not self.failed,
            why=self.failed,
            seconds=seconds,
            peak_Nm=watch.peak.tolist(),
            rms_Nm=watch.rms.tolist(),
            energy_J=self.energy if self.reached is not None else None,
            position_error_m=self.away[0],
            yaw_error_deg=float(np.degrees(self.away[1])),
            speed_mps=speed if rolls and self.rolls else None,
            average_mps=way / seconds if rolls and seconds else None,
            heading_error_deg=abs(float(np.degrees(turn))) if rolls else None,
            push_ups=watch.push_ups.count if trial.name == "push_ups" else None,
            gathers=(watch.gathering.begun, watch.gathering.done),
            gather_lean_deg=float(np.degrees(watch.gathering.lean)),
            gather_slid_m=watch.gathering.slid,
            gather_force_N=watch.gathering.force,
            events=[f"{e.stamp:.2f} {e.before}>{e.after}: {e.why}" for e in self._events()],
        )

    def _events(self) -> list[Event]:
        return [e for e in self.stack.machine.events if e.before is not e.after]


def motion_trials(
    names: Sequence[str] = (),
    *,
    seeds: int,
    seed: int = 0,
    motions: Mapping[str, Motion] | None = None,
    policy: Path | None = None,
    workers: int = 0,
    progress: Progress | None = None,
) -> Motions:
    """Trials by name over ``seeds`` seeds each.

    Args:
        names: Of :data:`TRIALS`; all if none.
        seeds: Number of seeds, >= 1.
        seed: The first.
        motions: By name; the shipped ones if not given.
        policy: ONNX file that crawls; the shipped one if not given.
        workers: Processes; 0 takes one a CPU.
        progress: Called with the share done after each run.

    Raises:
        UnknownName: There is no such trial.
        PolicyError: The policy cannot be read, or drives another body.
        InvalidInput: Less than one seed, or a motion is not there.
    """
    chosen = list(dict.fromkeys(names)) or list(TRIALS)
    there = dict.fromkeys(motion_names()) if motions is None else motions
    for name in chosen:
        if name not in TRIALS:
            raise UnknownName("motion trial", name, TRIALS)
        lacks = sorted(needed(TRIALS[name]) - set(there))
        if lacks:
            raise InvalidInput(
                f"trial '{name}' needs the motion '{lacks[0]}', which is not there; there are:"
                f" {', '.join(sorted(there)) or 'none'}"
            )
    if seeds < 1:
        raise InvalidInput(f"seeds: expected a whole number >= 1, got {seeds}")
    if motions is None:
        for name in motion_names():
            load_motion(name)  # a mistake in a file shows before the work begins
    if policy is not None:
        controller_of(policy, "crawl")
    jobs = [(name, seed + k) for name in chosen for k in range(seeds)]
    work = partial(run_trial, motions=motions, policy=policy)
    runs = run_jobs(work, jobs, workers=workers, progress=progress)
    return summarise(runs, seeds=seeds, seed=seed)
