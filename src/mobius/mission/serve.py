"""The live robot for others to drive: stack, pace and ROS 2 bridge in one loop."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mobius.bridge.about import About
from mobius.bridge.link import Node
from mobius.bridge.live import Live
from mobius.bridge.pilot import Gamepad, Remote
from mobius.bridge.record import McapRecorder
from mobius.control.bodies import BODIES
from mobius.errors import MapError
from mobius.mission.body import DRIVABLE
from mobius.mission.errand import Errand
from mobius.mission.floor import floor_of
from mobius.mission.footprint import footprint_of
from mobius.mission.prepare import open_world, room_of
from mobius.mission.summary import versions
from mobius.model.urdf import build_urdf
from mobius.modes import check_roll
from mobius.pace import Pace, Timing
from mobius.robot import TICK
from mobius.stack import Sample, Stack
from mobius.types import Mode, Plan, Pose, StateEstimate
from mobius.world import World

PRIMARY = ("crawl", "biped", "roll", "push_ups")
"""Modes that may be asked for."""
TRUTH_EVERY = 20
"""Ticks between two true poses (/mobius/ground_truth, 30 Hz)."""
STATUS_EVERY = 300
"""Ticks between two words on how it goes (2 Hz)."""
HERE = Pose(p=np.zeros(3), q=np.array([1.0, 0.0, 0.0, 0.0]))
"""Odom is map: the robot is told where it starts."""


@dataclass(eq=False)
class Served:
    """A robot ready to be served."""

    stack: Stack
    robot: Any
    world: World | None
    errand: Errand | None
    remote: Remote
    scene: str = ""
    """The scene as MJCF, for logs; empty on the endless floor."""
    seed: int = 0
    """Of friction, mass, delay and sensors."""
    plan: Plan | None = None
    """The plan said last."""

    def about(self) -> About:
        """What a log says of it as a whole."""
        return About(
            map="" if self.world is None else self.world.name,
            seed=self.seed,
            variation=asdict(self.robot.variation),
            versions=versions(),
            scene=self.scene,
        )


def build_served(
    source: str | Path | None = None,
    *,
    start: Sequence[float] | None = None,
    modes: Sequence[str] = PRIMARY,
    seed: int = 0,
    randomised: bool = False,
    policy: Path | str | None = None,
    speed: float = 1.0,
    deadman: int = Gamepad.held,
) -> Served:
    """A live robot on an endless floor, or on a map where goals can be given.

    Args:
        source: Map file, or the name of a shipped map.
        start: (2,) [m]; the map's own if not given.
        modes: Primary modes it has.
        seed: Of friction, mass, delay and sensors.
        randomised: Whether they are drawn at all.
        policy: What drives the crawling robot; the shipped one if not given.
        speed: Share of the fastest twist that is let through.
        deadman: Button of /joy that must be held.

    Raises:
        MobiusError: A mistake in map, start, modes, policy or speed.
    """
    from mobius.assemble import Start, build_sim_stack, flat_model
    from mobius.model.robot import load_spec
    from mobius.world.scene import build_scene

    room = footprint_of(policy)
    world = (
        None if source is None else open_world(source, start=start, need=("start",), footprint=room)
    )
    place, ground = (0.0, 0.0), None
    if world is None:
        model, scene = flat_model(), ""
    else:
        try:
            spec = build_scene(world, load_spec("full"))
            model, scene = spec.compile(), spec.to_xml()
        except ValueError as error:
            raise MapError(
                f"map '{world.name}': physics cannot build it ({' '.join(str(error).split())})"
            ) from None
        assert world.grid.start is not None  # open_world saw to it
        place, ground = (float(world.grid.start[0]), float(world.grid.start[1])), floor_of(world)
    model.opt.timestep = TICK
    body = "crawl" if "crawl" in modes else "biped" if "biped" in modes else str(modes[0])
    crawl = policy or ("rough" if world is not None and world.rough else "flat")
    stack, robot = build_sim_stack(
        model,
        Start(body=body, xy=place, seed=seed, randomised=randomised),
        policy={"crawl": crawl},
        ground=ground,
        modes=modes,
    )
    drivable = [m for m in DRIVABLE if m.value in modes]
    errand = None if world is None else Errand(world, drivable)
    limits = {b.mode: (np.array(b.command_low), np.array(b.command_high)) for b in BODIES.values()}
    pad = Gamepad(held=deadman)
    remote = Remote(
        stack.machine, limits, speed=speed, gamepad=pad, errands=errand, check=_check(world)
    )
    return Served(stack, robot, world, errand, remote, scene, seed)


def _check(world: World | None) -> Callable[[Mode, StateEstimate], None] | None:
    """What a mode that is asked for has to pass: a roll must have room on the map."""
    if world is None:
        return None
    room = room_of(world)

    def check(mode: Mode, belief: StateEstimate) -> None:
        if mode is Mode.ROLL:
            check_roll(belief, room)

    return check


def serve(
    served: Served,
    node: Node,
    *,
    seconds: float | None = None,
    pace: Pace | None = None,
    recorder: McapRecorder | None = None,
    pictures: Callable[[Any, float], Any] | None = None,
    watch: Callable[[Sample, Timing], None] | None = None,
    ended: Callable[[], bool] | None = None,
) -> Timing:
    """Turn the robot in real time, say what it does, do what is heard.

    Args:
        served: From :func:`build_served`.
        node: Open; stays open.
        seconds: For how long, robot's time; for ever if not given.
        pace: Against which clock.
        recorder: Gets the same nouns.
        pictures: Called at 60 Hz with the robot and its time [s]; gives a
            :class:`mobius.bridge.camera.Picture` when one is ready, else None.
        watch: Called twice a second.
        ended: Asked at every tick whether to end now.

    Returns:
        How well real time was kept.
    """
    pace = pace or Pace(served.stack)
    without = (
        ()
        if pictures is not None
        else tuple(f"/camera/color/{name}" for name in ("image_raw", "camera_info"))
    )
    live = Live(node, served.remote, without=without)
    said = _Said(served, live, recorder)
    said.first()
    stack, remote = served.stack, served.remote
    until = np.inf if seconds is None else stack.tick + round(seconds / TICK)
    belief: StateEstimate | None = None
    sample: Sample | None = None
    truth: StateEstimate | None = None
    with _calm():
        while stack.tick < until and not (ended is not None and ended()):
            remote.attend(belief)
            node.check()
            turned = pace.turn(remote.command)
            if turned is not None:  # said in the next tick, when the round that acted is done
                sample, belief = turned, turned.belief
                truth = served.robot.truth() if turned.tick % TRUTH_EVERY == 0 else None
                continue
            if sample is None:
                continue
            picture = None
            if pictures is not None:
                picture = pictures(served.robot, sample.tick * TICK)
            timing = pace.timing() if sample.tick % STATUS_EVERY == 0 else None
            status = None if timing is None else _status(served, timing)
            said.sample(sample, truth, picture, status)
            if watch is not None and timing is not None:
                watch(sample, timing)
            sample = None
    return pace.timing()


class _Said:
    """What goes to the graph and, the same, into the log."""

    def __init__(self, served: Served, live: Live, recorder: McapRecorder | None) -> None:
        self._served, self._live, self._recorder = served, live, recorder

    def first(self) -> None:
        """What late listeners need."""
        world = self._served.world
        self._once(0.0, pose_MO=HERE, description=build_urdf())
        if world is not None:
            self._once(0.0, grid=world.grid)

    def sample(
        self,
        sample: Sample,
        truth: StateEstimate | None,
        picture: Any,
        status: dict[str, Any] | None,
    ) -> None:
        """One 60 Hz sample, and the plan where it is new."""
        nouns: dict[str, Any] = {
            "frame": sample.frame,
            "belief": sample.belief,
            "command": sample.command,
            "target": sample.sent,
            "truth": truth,
        }
        self._live.step(sample.tick, **nouns, status=status, picture=picture)
        if self._recorder is not None:
            self._recorder.step(sample.tick, **nouns)
        errand = self._served.errand
        plan = None if errand is None else errand.plan
        if plan is not None and plan is not self._served.plan:
            self._served.plan = plan
            self._once(sample.tick * TICK, plan=plan)

    def _once(self, stamp: float, **nouns: Any) -> None:
        self._live.once(**nouns)
        if self._recorder is not None:
            self._recorder.once(stamp=stamp, **nouns)


def _status(served: Served, timing: Timing) -> dict[str, Any]:
    """What the robot says of itself twice a second."""
    machine, errand = served.stack.machine, served.errand
    return {
        "mode": machine.mode.value,
        "wanted": served.remote.wanted.value,
        "available": sorted(m.value for m in machine.available if m is not Mode.STOP),
        "notice": machine.notice,
        "refused": [f"{k}: {why}" for k, why in sorted(dict(served.remote.refused).items())],
        "goal": "no map" if errand is None else errand.state,
        "goal_notice": "" if errand is None else errand.notice,
        "real_time_factor": round(timing.recent_factor, 4),
        "miss_share": round(timing.miss_share, 5),
    }


@contextmanager
def _calm() -> Iterator[None]:
    """No full garbage collection while the loop turns: what stands now will stand till the end."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
