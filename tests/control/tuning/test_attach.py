"""A tuner on the loop of both arms."""

import numpy as np
import pytest

from mobius.control.admittance import DT, SERVO_LAG, ForceLoop, mobius_config
from mobius.control.admittance.arms import arms_pose
from mobius.control.tuning import Attached, Tuner
from mobius.errors import InvalidInput, UnknownName
from mobius.model.robot import keyframe_joints
from mobius.types import SensorFrame

TARGETS = keyframe_joints("crawl")[1]
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
Z_ONLY = [i == 2 for i in range(6)]
K = 3000.0


class Table:
    """Both hands on springs of 3000 N/m, carried by servos with the nominal lag."""

    def __init__(self, loop: ForceLoop) -> None:
        self.loop, self.y, self.late = loop, np.zeros(2), np.zeros(2)
        self.tool = loop.law.configs[0].gravity_compensation

    def frame(self, rng: np.random.Generator) -> SensorFrame:
        still = np.zeros(22)
        blank = SensorFrame(0.0, TARGETS, still, still, np.zeros((2, 6)), np.zeros(3), np.zeros(3))
        up_S, R_CS = self.loop.frames(blank, LEVEL)
        self.f = 10.0 - K * self.y
        f = self.f[:, None] * R_CS[:, 2] - self.tool.cog_force * up_S
        tau = np.cross([0, 0, -0.086], self.f[:, None] * R_CS[:, 2])
        tau -= np.cross(self.tool.cog_pos, self.tool.cog_force * up_S)
        wrench = -np.concatenate([f, tau], axis=1) + 0.1 * rng.standard_normal((2, 6))
        return SensorFrame(0.0, TARGETS, still, still, wrench, np.zeros(3), np.zeros(3))

    def move(self, q: np.ndarray) -> None:
        height = arms_pose(q[:12].reshape(2, 6))[0][:, 2] - self.loop.p0_B[:, 2]
        self.y = self.y + (1 - np.exp(-DT / SERVO_LAG)) * (self.late - self.y)
        self.late = height


def pressed(seconds: float, *, tuned: bool, lose: bool = False):
    config = mobius_config(
        selected_axes=Z_ONLY,
        damping=[4000.0] * 3 + [5.0] * 3,
        integral_force=[0.1] * 6,
        position_max=[0.15] * 6,
    )
    loop = ForceLoop(config, config)
    loop.start(TARGETS)
    table, rng = Table(loop), np.random.default_rng(0)
    attached = Attached(Tuner(config.axis(2), 2), [(0, "z"), (1, "z")])
    error, reports = [], []
    for k in range(round(seconds / DT)):
        if k % 450 == 0:
            wish = rng.uniform(6.0, 16.0, 2)
        loop.wrench_reference[:, 2] = wish
        frame = table.frame(rng)
        attached.before(loop)
        silent = lose and k % 300 < 20
        wrench = np.full((2, 6), np.nan) if silent else None
        out = loop.step(frame, LEVEL, wrench_S=wrench)
        report = attached.after(loop, out) if tuned else None
        if report is not None:
            reports.append(report)
        table.move(out.command.q)
        error.append(table.f - wish)
    return loop, reports, np.array(error)


def test_both_arms_get_the_gains_and_the_force_error_falls():
    loop, reports, error = pressed(7.0, tuned=True)
    assert {r.verdict for r in reports} & {"taken", "shrunk"}
    np.testing.assert_array_equal(loop.law.gains[0, 2], loop.law.gains[1, 2])
    assert loop.law.gains[0, 2, 1] == reports[-1].gains.D
    assert reports[-1].contact.high == pytest.approx(K, rel=0.15)
    plain = pressed(7.0, tuned=False)[2]
    late = slice(1200, None)
    assert np.sqrt(np.mean(error[late] ** 2)) < 0.75 * np.sqrt(np.mean(plain[late] ** 2))


def test_a_sensor_that_comes_and_goes_teaches_nothing():
    """A window is 1.5 s; with a silence each second none is whole."""
    loop, reports, _ = pressed(4.0, tuned=True, lose=True)
    assert not reports
    assert loop.law.gains[0, 2, 1] == 4000.0


def test_what_a_law_does_that_takes_over_by_degrees_is_not_shown_to_the_tuner():
    config = mobius_config(selected_axes=Z_ONLY)
    loop = ForceLoop(config, config)
    loop.start(TARGETS)
    table, rng = Table(loop), np.random.default_rng(0)
    tuner = Tuner(config.axis(2), 2)
    attached, kept = Attached(tuner, [(0, "z"), (1, "z")]), []
    for k in range(100):
        attached.before(loop)
        wrench = np.full((2, 6), np.nan) if k < 5 else None
        out = loop.step(table.frame(rng), LEVEL, wrench_S=wrench)
        attached.after(loop, out)
        table.move(out.command.q)
        kept.append(len(tuner._rows))
    resume = round(config.resume_time / DT)
    assert max(kept[: 4 + resume]) == 0 < kept[-1]


def test_mistakes_are_told():
    tuner = Tuner(mobius_config().axis(2), 1)
    with pytest.raises(UnknownName, match="0 or 1, z"):
        Attached(tuner, [(2, "z")])
    with pytest.raises(InvalidInput, match=r"expected shape \(1, 2\)"):
        Attached(tuner, [(0, "y"), (1, "y")])
    attached = Attached(tuner, [(0, "y"), (1, "y")], mix=[[0.5, -0.5]])
    with pytest.raises(InvalidInput, match="call before"):
        attached.after(None, None)
