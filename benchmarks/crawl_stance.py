"""What an ideal trot costs, by where the feet stand from the yaw axes, and how high they swing.

    python benchmarks/crawl_stance.py [--json FILE]

No learning and no simulation: the trunk glides level at constant speed, feet in stance rest on
the ground, feet in swing come to a constant speed and to rest again within a fifth of the swing.
Closed-form kinematics give the joints over a stride of the crawl's gait clock, inverse dynamics
of the model (rotor inertia, dry friction, closed five-bars) the servo torques, with the smallest
ground forces that carry the trunk. Power is the mean of sum |torque * rate|, as in evaluation.
It compares stances; it does not forecast a policy, which need not glide, and may lift its trunk.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import body_of
from mobius.files import write_json_atomic
from mobius.model import arm, leg, robot
from mobius.model.dimensions import LimbGeometry, limb_geometry
from mobius.model.joints import JOINTS, LIMB_JOINTS
from mobius.model.poses import Stance
from mobius.model.servo import servo_of
from mobius.train.presets import WIDE
from mobius.types import LIMBS

Array = NDArray[np.float64]

SAMPLES = 240
"""A stride."""
DUTY = 0.5
"""Share of a stride that a foot is in the air: the clock's swing and its slack."""
RAMP = 0.2
"""Share of the swing in which a foot comes to its speed, and again to rest."""
LIFT = 0.03
"""Top of a swing where the stances are compared [m]."""
LIFTS = (0.038, 0.028, 0.020)
"""Tops of a swing that are compared in the stance of the policy [m]."""
GAIT = body_of("crawl").gait
COMMANDS = {
    "forward 0.4": (0.4, 0.0),
    "forward 0.7": (0.7, 0.0),
    "left 0.286": (0.0, 0.286),
    "left 0.5": (0.0, 0.5),
}
"""Trunk velocities [m/s]."""
SHOWN = ("shoulder_yaw", "shoulder_motor", "hip_yaw", "hip_motor")
BEND = 1e-6
"""Step of numerical derivatives [rad]."""


@dataclass(frozen=True)
class Cost:
    """An ideal trot."""

    power_W: float
    by_joint_W: dict[str, float]
    """Mean of |torque * rate| by kind of joint, all limbs."""
    yaw_rpm: float
    """Fastest hip or shoulder yaw."""
    fastest_rpm: float
    """Fastest joint."""
    margin_rad: float
    """Least distance of a joint from its limits; negative is past them."""
    hold: float
    """Largest torque of standing still, as a share of stall."""


def limb_tip(g: LimbGeometry, q: Array) -> Array:
    """Fingertip or sole point (..., 3) in B [m] for limb angles q (..., 6 or 4)."""
    return arm.gripper_pose(g, q)[0] if g.is_arm else leg.sole_position(g, q)


def limb_ik(g: LimbGeometry, q: Array, want: Array) -> Array:
    """Limb angles (n, k) with the tip at ``want`` (n, 3) [m], from q (n, k) by Newton's method;
    only yaw and cranks move. NaN where it does not get there.
    """
    q, bends = q.copy(), BEND * np.eye(q.shape[1])[:3]
    for _ in range(30):
        tip = limb_tip(g, q)
        J = np.stack([(limb_tip(g, q + bend) - tip) / BEND for bend in bends], axis=-1)
        step = np.linalg.solve(J, (want - tip)[..., None])[..., 0]
        q[:, :3] += np.clip(step, -0.2, 0.2)
    q[~(np.abs(want - tip).max(axis=1) < 1e-6)] = np.nan
    return q


def foot_paths(
    home: Array, velocity: Array, period: float, lift: float
) -> tuple[Array, NDArray[np.bool_]]:
    """Feet in B (n, 4, 3) [m] over a stride and whether they are on the ground (n, 4)."""
    phase = (np.arange(SAMPLES)[:, None] / SAMPLES + np.array(GAIT.offsets)) % 1.0
    air = phase < DUTY
    u = np.where(air, phase / DUTY, 0.0)
    # forward speed in the air, in parts of the trunk's: from -1 over a ramp to a plateau and back
    plateau = ((1 - DUTY) / DUTY + RAMP) / (1 - RAMP)
    fine = np.linspace(0.0, 1.0, 2001)
    ramp = np.minimum(np.minimum(fine, 1 - fine) / RAMP, 1.0)
    speed = -1.0 + (1.0 + plateau) * 0.5 * (1 - np.cos(np.pi * ramp))
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) / 2000 * DUTY
    half = 0.5 * (1 - DUTY)
    offset = np.where(air, -half + np.interp(u, fine, way), half - (phase - DUTY))
    feet = home + period * offset[..., None] * np.array([*velocity, 0.0])
    feet[..., 2] += np.where(air, np.sin(np.pi * u) ** 2 * lift, 0.0)
    return feet, ~air


def joint_path(feet: Array, posture: Array) -> Array:
    """(n, 22) joints that follow the feet (n, 4, 3); NaN where one cannot."""
    q = np.tile(posture, (len(feet), 1))
    for i, limb in enumerate(LIMBS):
        at = LIMB_JOINTS[limb]
        q[:, at] = limb_ik(limb_geometry(limb), q[:, at], feet[:, i])
    return q


class Dynamics:
    """Inverse dynamics of the robot with its five-bars closed."""

    def __init__(self) -> None:
        self.model = robot.load_model("full", floor=False)
        self.data = mujoco.MjData(self.model)
        self.at = robot.addresses(self.model)
        self.passive = {
            limb: [int(self.model.joint(f"{limb}_{k}").dofadr[0]) for k in ("coupler", "distal")]
            for limb in LIMBS
        }

    def path(self, q: Array, velocity: Array, period: float) -> tuple[Array, Array, Array]:
        """qpos, qvel, qacc (n, ...) of a stride; joint rates by periodic differences."""
        at, dt = self.at, period / SAMPLES
        qpos = np.tile(self.model.qpos0, (len(q), 1))
        qpos[:, at.qpos] = q
        qpos[:, at.coupler], qpos[:, at.distal] = robot.passive_angles(q)
        qpos[:, :7] = [0, 0, 0, 1, 0, 0, 0]
        qvel, qacc = np.zeros((2, len(q), self.model.nv))
        joints = qpos[:, 7:]
        ahead, behind = np.roll(joints, -1, axis=0), np.roll(joints, 1, axis=0)
        qvel[:, 6:] = (ahead - behind) / (2 * dt)
        qacc[:, 6:] = (ahead - 2 * joints + behind) / dt**2
        qvel[:, :2] = velocity
        return qpos, qvel, qacc

    def torque(self, qpos: Array, qvel: Array, qacc: Array, stands: Array) -> Array:
        """Servo torques (22,) [N m] at the output with feet ``stands`` (4,) on the ground."""
        m, d = self.model, self.data
        d.qpos[:], d.qvel[:], d.qacc[:] = qpos, qvel, qacc
        mujoco.mj_fwdPosition(m, d)
        mujoco.mj_fwdVelocity(m, d)
        force = np.zeros(m.nv)
        mujoco.mj_rne(m, d, 1, force)
        force += m.dof_armature * qacc + m.dof_frictionloss * np.tanh(qvel / 0.05)
        J = np.zeros((4, 3, m.nv))
        for i, limb in enumerate(LIMBS):
            mujoco.mj_jacSite(m, d, J[i], None, m.site(f"{limb}_tip").id)
        down = J[stands].reshape(-1, m.nv)
        force -= down.T @ np.linalg.lstsq(down[:, :6].T, force[:6], rcond=1e-8)[0]
        return self._at_servos(qpos[self.at.qpos], force)

    def _at_servos(self, q: Array, force: Array) -> Array:
        """Forces of all joints (nv,) as torques of the servos: cranks move the passive ones."""
        torque = np.array(force[self.at.dof])
        for i, limb in enumerate(LIMBS):
            for crank in LIMB_JOINTS[limb].start + np.array([1, 2]):
                bend = BEND * np.eye(len(q))[crank]
                plus, minus = robot.passive_angles(q + bend), robot.passive_angles(q - bend)
                for dof, p, m in zip(self.passive[limb], plus, minus, strict=True):
                    torque[crank] += force[dof] * (p[i] - m[i]) / (2 * BEND)
        return torque


def trot(
    dynamics: Dynamics, stance: Stance, velocity: Array, *, raised: float = 0.0, lift: float = LIFT
) -> Cost | None:
    """An ideal trot, trunk ``raised`` [m], swings of ``lift`` [m]; None: a foot is out of reach."""
    posture = stance.joints()
    home = np.array([limb_tip(limb_geometry(x), posture[LIMB_JOINTS[x]]) for x in LIMBS])
    home[:, 2] -= raised
    posture = joint_path(home[None], posture)[0]
    period = GAIT.period / (1.0 + GAIT.quicken * float(np.linalg.norm(velocity)))
    feet, stands = foot_paths(home, velocity, period, lift)
    q = joint_path(feet, posture)
    if np.isnan(q).any() or np.isnan(posture).any():
        return None
    path = dynamics.path(q, velocity, period)
    torque = np.array([dynamics.torque(*row) for row in zip(*path, stands, strict=True)])
    rest = [row[0] for row in dynamics.path(posture[None], np.zeros(2), 1.0)]
    still = dynamics.torque(*rest, np.ones(4, dtype=bool))
    low, high = robot.joint_limits()
    margin = float(np.minimum(q - low, high - q)[:, :20].min())
    return _cost(torque[:, :20], path[1][:, dynamics.at.dof[:20]], still[:20], margin)


def _cost(torque: Array, rate: Array, still: Array, margin: float) -> Cost:
    stall = np.array([servo_of(j).stall_torque for j in JOINTS[:20]])
    power = np.abs(torque * rate).mean(axis=0)
    kinds = {k: [i for i, j in enumerate(JOINTS[:20]) if k in j] for k in SHOWN}
    rpm = np.abs(rate).max(axis=0) * 30 / np.pi
    return Cost(
        power_W=float(power.sum()),
        by_joint_W={k: float(power[i].sum()) for k, i in kinds.items()},
        yaw_rpm=float(rpm[kinds["shoulder_yaw"] + kinds["hip_yaw"]].max()),
        fastest_rpm=float(rpm.max()),
        margin_rad=margin,
        hold=float((np.abs(still) / stall).max()),
    )


def keyframe_stance() -> Stance:
    """That of keyframe ``crawl``."""
    q, polar = robot.keyframe_joints("crawl")[0], []
    for limb in ("left_arm", "left_leg"):
        g = limb_geometry(limb)
        x, y, _ = limb_tip(g, q[LIMB_JOINTS[limb]]) - g.hip_B
        polar += [float(np.hypot(x, y)), float(np.arctan2(x if g.is_arm else -x, y))]
    return Stance(*polar)


def trots() -> Iterator[dict[str, Any]]:
    """What is compared: name, stance, how much the trunk is raised, how high feet swing [m]."""
    now = keyframe_stance()
    rows = [("keyframe crawl", now, 0.0), ("the same, trunk 0.02 m up", now, 0.02)]
    for r in (0.18, 0.21, 0.24):
        kept = Stance(r, now.arm_turn, r, now.leg_turn)
        out = Stance(r, now.arm_turn / 2, r, now.leg_turn / 2)
        rows.append((f"all feet at {r} m, directions kept", kept, 0.0))
        rows.append((f"{r} m, turned halfway out", out, 0.0))
        rows.append((f"{r} m, straight out", Stance(r, 0.0, r, 0.0), 0.0))
    rows.append(("arms 0.24 m, 17 deg; legs 0.19 m, 11 deg", WIDE, 0.0))
    for name, stance, raised in rows:
        yield {"name": name, "stance": stance, "raised_m": raised, "lift_m": LIFT}
    for lift in LIFTS:
        name = f"{rows[-1][0]}; swings of {lift} m"
        yield {"name": name, "stance": WIDE, "raised_m": 0.0, "lift_m": lift}


def main() -> None:
    """Print, and write where asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    dynamics, rows = Dynamics(), []
    print("power [W] (shoulder yaw/cranks, hip yaw/cranks), fastest yaw and joint [rpm], margin")
    for case in trots():
        how = {"raised": case["raised_m"], "lift": case["lift_m"]}
        stance: Stance = case["stance"]
        costs = {c: trot(dynamics, stance, np.array(v), **how) for c, v in COMMANDS.items()}
        plain = {c: None if cost is None else asdict(cost) for c, cost in costs.items()}
        rows.append({**case, "stance": asdict(stance), "trots": plain})
        print(case["name"], flush=True)
        for command, cost in costs.items():
            if cost is None:
                print(f"  {command:12s} out of reach")
                continue
            parts = "/".join(f"{w:.0f}" for w in cost.by_joint_W.values())
            print(
                f"  {command:12s} {cost.power_W:6.1f} ({parts})  {cost.yaw_rpm:4.0f}"
                f" {cost.fastest_rpm:4.0f} rpm  {cost.margin_rad:5.2f} rad  hold {cost.hold:.0%}"
            )
    if args.json is not None:
        write_json_atomic(args.json, {"stances": rows})


if __name__ == "__main__":
    main()
