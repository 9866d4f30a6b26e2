"""A recorded run, ready to be looked at: everything on the clock of the joints.

run = open_run("runs/demo")
run.t, run.q, run.true.p_M, run.modes
model = run.model(); qpos = run.qpos(model)
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mobius.bridge.about import About
from mobius.bridge.from_ros import map_to_odom, plan_facts
from mobius.bridge.read_log import Log, read_log
from mobius.bridge.series import between, held, latest, read_only, turned_between
from mobius.control.bodies import BODIES
from mobius.control.observation import heading_twist
from mobius.errors import InvalidInput
from mobius.geometry import quat_mul, rotate
from mobius.types import GridMap, Mode, Plan, Pose, StateEstimate

__all__ = ["Run", "Track", "open_run"]

Array = NDArray[np.float64]
Whose = Literal["true", "believed"]


@dataclass(frozen=True, eq=False)
class Track:
    """Where the trunk was, by the simulator or by the estimator; rows are those of the run."""

    p_M: Array
    """(n, 3) [m], frame M."""
    q_M: Array
    """(n, 4) wxyz."""
    twist_H: Array
    """(n, 3) vx, vy [m/s], wz [rad/s] in the heading frame of the body of that moment."""


@dataclass(frozen=True, eq=False)
class Run:
    """A log, with a row for every message of ``/joint_states`` (60 Hz).

    Topics recorded less often hold their last value (poses: linear between two); before a
    topic's first message stands the first. A topic that was not recorded is None.
    """

    path: Path
    about: About
    """Map, seed, variation, versions and scene, as far as they were recorded."""
    t: Array
    """(n,) log time [s], rising; begins where the recording does."""
    q: Array
    """(n, 22) encoder angles [rad], order JOINTS."""
    dq: Array
    """(n, 22) [rad/s]."""
    torque: Array
    """(n, 22) as the servos measured it [N m]."""
    q_target: Array | None
    """(n, 22) what ``robot.write`` let through [rad]."""
    wrench_S: Array | None
    """(n, 2, 6) force [N], torque [N m] at the left and right wrist."""
    gyro_I: Array | None
    """(n, 3) [rad/s]."""
    accel_I: Array | None
    """(n, 3) specific force [m/s^2]."""
    true: Track | None
    """By the simulator; None for a real robot."""
    believed: Track | None
    """By the estimator, put into frame M."""
    cmd_twist_H: Array | None
    """(n, 3) commanded vx, vy [m/s], wz [rad/s]."""
    contact: Array | None
    """(n, 4) believed probability of ground contact, order LIMBS."""
    modes: tuple[str, ...]
    """n mode names; empty strings where none was recorded."""
    grid: GridMap | None
    plans: tuple[tuple[float, Plan], ...]
    """When each plan was made [s], and the plan."""
    obstacles: tuple[tuple[float, Array], ...]
    """When obstacles moved [s], and the poses (k, 7) of the scene's mocap bodies from then on."""
    counts: Mapping[str, int]
    """Messages per topic."""
    summary: Mapping[str, Any]
    """``summary.json`` beside the log; empty if there is none."""
    notes: tuple[str, ...]
    """What a user should know: how far a cut log reads, what was not recorded."""
    complete: bool
    """Whether the log was closed; False where it is cut off, damaged or still being written."""

    def __len__(self) -> int:
        """Rows."""
        return len(self.t)

    @property
    def power(self) -> Array:
        """(n,) mechanical power, sum of |torque * rate| as measured [W]."""
        return np.abs(self.torque * self.dq).sum(axis=1)

    @property
    def distance(self) -> float:
        """Way of the trunk over the floor [m], by the truth where it is known; else 0."""
        track = self.true or self.believed
        if track is None:
            return 0.0
        return float(np.linalg.norm(np.diff(track.p_M[:, :2], axis=0), axis=1).sum())

    def at(self, t: float) -> int:
        """Row that was last at a time [s]; the first before the beginning."""
        return int(latest(self.t, t))

    def plan_at(self, t: float) -> Plan | None:
        """The plan in force at a time [s]; the first one before it was made."""
        return self.plans[int(latest([s for s, _ in self.plans], t))][1] if self.plans else None

    def mocap_at(self, t: float) -> Array | None:
        """(k, 7) poses of the scene's mocap bodies at a time [s], None where none was recorded."""
        if not self.obstacles:
            return None
        return self.obstacles[int(latest([s for s, _ in self.obstacles], t))][1]

    def model(self) -> Any:
        """The scene the run was recorded in, compiled; the robot on an endless floor where the log
        holds none (``notes`` says so).

        Raises:
            InvalidInput: The scene in the log cannot be built.
        """
        from mobius.model.robot import compile_scene, load_model

        if not self.about.scene:
            return load_model("full")
        try:
            return compile_scene(self.about.scene)
        except InvalidInput as error:
            raise InvalidInput(f"{self.path}: {error}") from None

    def qpos(self, model: Any, of: Whose | None = None) -> Array:
        """(n, nq) whole configurations: the recorded joints, loops closed, trunk on its track.

        Where measured crank angles admit no five-bar, its passive joints keep the angles of the
        row before; the recorded joints are never changed.

        Args:
            model: A compiled scene with the whole robot, such as :meth:`model` gives.
            of: Whose track; the true one where it is known, else the believed one.

        Raises:
            InvalidInput: The track asked for was not recorded.
        """
        from mobius.model.robot import configurations

        track = (self.true or self.believed) if of is None else getattr(self, of)
        if track is None:
            has = [name for name in ("true", "believed") if getattr(self, name) is not None]
            raise InvalidInput(
                f"{self.path}: the log holds no {of or 'trunk'} pose; it has"
                f" {', '.join(has) or 'neither /odom nor /mobius/ground_truth'}"
            )
        return configurations(model, self.q, p=track.p_M, quat=track.q_M)[0]


def open_run(path: str | Path) -> Run:
    """Read a run.

    Args:
        path: The folder of a run, or a ``.mcap`` file; one that was cut off opens, too.

    Raises:
        InvalidInput: There is no log, it is none, it holds no joints, or others than the robot's.
    """
    log = read_log(path)
    times, joints = log.series("/joint_states")
    if not joints:
        raise InvalidInput(f"{log.path}: {_why_empty(log)}")
    t = read_only(np.array(times))
    q, dq, torque = (read_only(np.array([row[k] for row in joints])) for k in range(3))
    modes = _modes(log, t)
    poses_MO = [p for p in log.series("/tf_static", map_to_odom)[1] if p is not None]
    pose_MO = poses_MO[0] if poses_MO else None
    commands = "/mobius/command" if "/mobius/command" in log.messages else "/cmd_vel"
    imu_t, imu = log.series("/imu/data")
    plans = _plans(log)
    return Run(
        path=log.path,
        about=log.about,
        t=t,
        q=q,
        dq=dq,
        torque=torque,
        q_target=_targets(log, t),
        wrench_S=_wrenches(log, t),
        gyro_I=held(imu_t, [row[0] for row in imu], t),
        accel_I=held(imu_t, [row[1] for row in imu], t),
        true=_track(log.series("/mobius/ground_truth"), t, modes, None),
        believed=_track(log.series("/odom"), t, modes, pose_MO),
        cmd_twist_H=held(*log.series(commands), t),
        contact=held(*log.series("/mobius/contacts"), t),
        modes=modes,
        grid=(log.series("/map")[1] or [None])[-1],
        plans=plans,
        obstacles=tuple(zip(*log.series("/mobius/obstacles"), strict=True)),
        counts=dict(sorted(log.counts.items())),
        summary=_summary(log.path),
        notes=_notes(log),
        complete=not log.problem,
    )


def _why_empty(log: Log) -> str:
    if log.problem:
        return f"{log.problem}: no joint angles can be read; there is nothing to show"
    has = ", ".join(sorted(log.counts)) or "no topic"
    return f"expected /joint_states, got {has}; there is nothing to show"


def _modes(log: Log, t: Array) -> tuple[str, ...]:
    times, modes = log.series("/mobius/mode")
    if not times:
        return ("",) * len(t)
    return tuple(modes[k].value for k in latest(times, t))


def _targets(log: Log, t: Array) -> Array | None:
    times, commands = log.series("/mobius/joint_targets")
    return held(times, [command.q for command in commands], t)


def _wrenches(log: Log, t: Array) -> Array | None:
    sides = [held(*log.series(f"/{side}_gripper/wrench"), t) for side in ("left", "right")]
    left, right = sides
    return None if left is None or right is None else read_only(np.stack([left, right], axis=1))


def _track(
    series: tuple[list[float], list[StateEstimate]],
    t: Array,
    modes: Sequence[str],
    pose_MO: Pose | None,
) -> Track | None:
    times, states = series
    if not times:
        return None
    p, q, v, w = (np.stack([getattr(s, k) for s in states]) for k in ("p_OB", "q_OB", "v_B", "w_B"))
    if pose_MO is not None:
        p, q = pose_MO.p + rotate(pose_MO.q, p), quat_mul(pose_MO.q, q)
    q, v, w = turned_between(times, q, t), between(times, v, t), between(times, w, t)
    twist = np.empty((len(t), 3))
    biped = np.array([mode == Mode.BIPED.value for mode in modes])
    for name, rows in (("biped", biped), ("crawl", ~biped)):
        v_H, w_H = heading_twist(BODIES[name], q[rows], v[rows], w[rows])
        twist[rows] = np.column_stack([v_H[:, :2], w_H[:, 2]])
    return Track(p_M=between(times, p, t), q_M=q, twist_H=read_only(twist))


def _plans(log: Log) -> tuple[tuple[float, Plan], ...]:
    """Path and modes of a plan travel apart; those of the same moment belong together."""
    paths = dict(zip(*log.series("/plan"), strict=True))
    facts = dict(zip(*log.series("/mobius/plan_modes", plan_facts), strict=True))
    try:
        return tuple((t, _plan(facts[t], paths[t])) for t in facts if t in paths)
    except (InvalidInput, KeyError, TypeError, ValueError) as error:
        raise InvalidInput(f"{log.path}: /mobius/plan_modes and /plan: {error}") from None


def _plan(said: Mapping[str, Any], xy_M: Array) -> Plan:
    return Plan(
        cells=said["cells"],
        modes=tuple(Mode(m) for m in said["modes"]),
        xy_M=xy_M,
        status=said["status"],
        objective=said["objective"],
        bound=said["bound"],
        solve_s=1e-3 * said["solve_ms"],
    )


def _summary(path: Path) -> dict[str, Any]:
    try:
        found = json.loads((path.parent / "summary.json").read_text())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) and path.name == "run.mcap" else {}


def _notes(log: Log) -> tuple[str, ...]:
    notes = list(log.remarks)
    if log.problem:
        notes.append(f"{log.path} is {log.problem}; it reads up to {log.end:.2f} s")
    if not log.about.scene:
        notes.append("the log holds no scene; the robot is shown on an empty floor")
    return tuple(notes)
