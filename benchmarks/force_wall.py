"""The tuner on the simulated arm: the left hand presses on a spring, in MuJoCo.

    python benchmarks/force_wall.py [--stiffness 500 5000 50000] [--seed 0]

The trunk is fixed, everything else is the robot: servos with their torque-speed lines and dry
friction, five-bars, tool weight, noise and drift of the wrists. The hand presses down on a
frictionless spring table with wishes that change between 5 and 20 N; first gains are those of
``mobius eval tuning`` (one_for_all). The servos give way under load, so that the table is
felt in series with the arm; what the tuner estimates is what it feels.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from mobius.control.admittance import AdmittanceConfig, AxisGains, ForceLoop, mobius_config
from mobius.control.tuning import Attached, Report, Tuner
from mobius.evaluate.contact import Contact, references
from mobius.evaluate.tuning import mediocre
from mobius.files import write_json_atomic
from mobius.model.joints import JOINTS
from mobius.model.robot import keyframe, load_spec
from mobius.sense.noise import WrenchNoise
from mobius.types import SensorFrame

RESULTS = Path(__file__).parent / "results" / "force_wall.json"
TUNE_S, JUDGE_S, SETTLE_S = 30.0, 8.0, 1.5
Z = 2
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])


class PressedHand:
    """The robot with its trunk fixed and its left hand on a spring table."""

    def __init__(self, stiffness: float, seed: int) -> None:
        spec = load_spec("full")
        spec.delete(spec.joint("base"))
        for key in list(spec.keys):
            spec.delete(key)
        self.model = spec.compile()
        self.model.opt.timestep = 1 / 600
        self.data = mujoco.MjData(self.model)
        qpos, self.targets = keyframe("crawl")
        self.data.qpos[:], self.data.ctrl[:] = qpos[7:], self.targets
        self.stiffness = stiffness
        self.noise = WrenchNoise(np.random.default_rng(seed))
        name = self.model.joint
        self.q = [int(name(j).qposadr[0]) for j in JOINTS]
        self.dof = [int(name(j).dofadr[0]) for j in JOINTS]
        self.motor = [self.model.actuator(j).id for j in JOINTS]
        self.tip = self.model.site("left_arm_tip").id
        self.body = self.model.body("left_arm_gripper_base").id
        self.adr = [int(self.model.sensor(f"{s}_wrist_force").adr[0]) for s in ("left", "right")]
        self.table: float | None = None
        self.force = 0.0

    def settle(self) -> None:
        """Let the arms sag, then put the table under the hand."""
        for _ in range(round(SETTLE_S * 600)):
            mujoco.mj_step(self.model, self.data)
        self.table = float(self.data.site_xpos[self.tip, 2])

    def tick(self, command: np.ndarray) -> None:
        """1/300 s."""
        self.data.ctrl[self.motor] = command
        for _ in range(2):
            if self.table is not None:
                deep = self.table - float(self.data.site_xpos[self.tip, 2])
                self.force = max(self.stiffness * deep, 0.0)
                lever = self.data.site_xpos[self.tip] - self.data.xipos[self.body]
                push = np.array([0.0, 0.0, self.force])
                self.data.xfrc_applied[self.body] = [*push, *np.cross(lever, push)]
            mujoco.mj_step(self.model, self.data)

    def frame(self, k: int) -> SensorFrame:
        """What the devices say."""
        wrench = np.array([self.data.sensordata[a : a + 6] for a in self.adr])
        still = np.zeros(22)
        return SensorFrame(
            stamp=k / 300,
            q=self.data.qpos[self.q],
            dq=self.data.qvel[self.dof],
            torque=still,
            wrench_S=self.noise.corrupt(wrench, 1 / 300),
            gyro_I=np.zeros(3),
            accel_I=np.array([0.0, 0.0, 9.81]),
        )


def config_of(g: AxisGains) -> AdmittanceConfig:
    """The left arm complies along z only."""

    def six(value: float, other: float) -> list[float]:
        return [other, other, value, other, other, other]

    return mobius_config(
        selected_axes=np.arange(6) == Z,
        mass=six(g.M, 1.0),
        damping=six(g.D, 100.0),
        stiffness=six(g.K, 0.0),
        force_gain=six(g.K_f, 1.0),
        integral_force=six(g.K_fi, 0.0),
        integral_position=six(g.K_pi, 0.0),
    )


def press(
    stiffness: float, gains: AxisGains, seconds: float, *, seed: int, wishes: int, tune: bool
) -> tuple[float, AxisGains, list[Report]]:
    """Force error [N] from 2 s on, gains at the end, reports."""
    hand = PressedHand(stiffness, seed)
    hand.settle()
    loop = ForceLoop(config_of(gains), config_of(gains))
    loop.start(hand.targets)
    ticks = round(seconds * 300)
    w = references(Contact("wall", stiffness), ticks, np.random.default_rng([seed, wishes]))[:, 0]
    w = 5.0 + (-8.0 - w) * 15.0 / 17.0
    tuner = Attached(Tuner(gains, 1), [(0, "z")]) if tune else None
    error, reports = np.zeros(ticks), []
    for k in range(ticks):
        loop.wrench_reference[0, Z] = w[k]
        frame = hand.frame(k)
        if tuner is not None:
            tuner.before(loop)
        out = loop.step(frame, LEVEL)
        report = tuner.after(loop, out) if tuner is not None else None
        if report is not None:
            reports.append(report)
        hand.tick(out.command.q)
        error[k] = hand.force - w[k]
    last = AxisGains(*(float(v) for v in loop.law.gains[0, Z]))
    return float(np.sqrt(np.mean(error[600:] ** 2))), last, reports


def measure(stiffness: float, seed: int) -> dict[str, Any]:
    """Before, tuning, after."""
    gains = mediocre("one_for_all", Contact("wall", stiffness), np.random.default_rng(seed))
    judged = {"seed": seed, "wishes": 2, "tune": False}
    before, _, _ = press(stiffness, gains, JUDGE_S, **judged)
    _, tuned, reports = press(stiffness, gains, TUNE_S, seed=seed, wishes=1, tune=True)
    after, _, _ = press(stiffness, tuned, JUDGE_S, **judged)
    felt = [r.contact.high for r in reports if r.contact is not None]
    return {
        "stiffness_N_per_m": stiffness,
        "felt_N_per_m": felt[-1] if felt else None,
        "force_rmse_before_N": before,
        "force_rmse_after_N": after,
        "force_rmse_change": after / before - 1.0,
        "gains_before": asdict(gains),
        "gains_after": asdict(tuned),
    }


def main() -> None:
    """Measure, print, keep."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stiffness", type=float, nargs="+", default=[500.0, 5000.0, 50_000.0])
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    rows = []
    for stiffness in args.stiffness:
        rows.append(measure(stiffness, args.seed))
        r = rows[-1]
        print(
            f"table {stiffness:7.0f} N/m, felt {r['felt_N_per_m'] or 0:6.0f} N/m: force error"
            f" {r['force_rmse_before_N']:.2f} -> {r['force_rmse_after_N']:.2f} N"
            f" ({100 * r['force_rmse_change']:+.0f} %), D {r['gains_before']['D']:.0f} ->"
            f" {r['gains_after']['D']:.0f}, K_f 1 -> {r['gains_after']['K_f']:.2f}",
            flush=True,
        )
    write_json_atomic(RESULTS, {"runs": rows})


if __name__ == "__main__":
    main()
