"""Table III and Algorithms 1 and 2, row by row: what each changes, and that it can be off."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.train.env import LocomotionEnv
from mobius.train.presets import Randomisation, preset_of

OFF = Randomisation().off()
N = 64


def env_with(**row) -> LocomotionEnv:
    cfg = replace(preset_of("crawl", "smoke").env, randomisation=replace(OFF, **row))
    return LocomotionEnv(cfg, N, seed=0, nthread=1)


@pytest.fixture(scope="module")
def quiet() -> LocomotionEnv:
    return env_with()


def test_without_any_row_all_robots_are_the_drawing(quiet):
    fields, model = quiet.sim.fields, quiet.sim.model
    np.testing.assert_array_equal(fields["mass"], np.tile(model.body_mass, (N, 1)))
    np.testing.assert_array_equal(fields["gain"], np.tile(model.actuator_gainprm, (N, 1, 1)))
    np.testing.assert_array_equal(fields["force"], np.tile(model.actuator_forcerange, (N, 1, 1)))
    assert (quiet.randomiser.friction == 0.8).all()
    assert (quiet.randomiser.delay() == 0).all() and not quiet.late.any()
    before = quiet.sim.qvel.copy()
    for _ in range(600):
        quiet.randomiser.kick(1 / 60)
    np.testing.assert_array_equal(before, quiet.sim.qvel)
    noisy = quiet.randomiser.noisy(*truth(quiet))
    for a, b in zip(noisy, truth(quiet), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-15)


def truth(env: LocomotionEnv) -> tuple[np.ndarray, ...]:
    q = np.tile([1.0, 0, 0, 0], (N, 1))
    return q, np.zeros((N, 3)), np.zeros((N, 3)), np.zeros((N, 14))


@pytest.mark.parametrize(
    ("row", "which", "half"),
    [
        ("linear_velocity", 1, 0.05),
        ("angular_velocity", 2, 0.15),
        ("encoder", 3, 0.005),
    ],
)
def test_noise_rows_are_uniform_and_touch_only_their_own_reading(row, which, half):
    env = env_with(**{row: half})
    noisy = env.randomiser.noisy(*truth(env))
    assert 0.8 * half < np.abs(noisy[which]).max() <= half
    for i, (a, b) in enumerate(zip(noisy, truth(env), strict=True)):
        if i != which:
            np.testing.assert_allclose(a, b, atol=1e-15)


def test_orientation_noise_turns_by_the_printed_degrees():
    env = env_with(orientation=np.deg2rad(np.pi))
    q = env.randomiser.noisy(*truth(env))[0]
    angle = 2 * np.arccos(np.clip(np.abs(q[:, 0]), 0, 1))
    assert 0.02 < angle.max() <= np.sqrt(3) * np.deg2rad(np.pi) * 1.01


def test_mass_row_scales_the_trunk_and_never_below_its_floor():
    env = env_with(trunk_mass=(-5.0, 5.0))
    trunk = env.sim.model.body("base_link").id
    mass = env.sim.fields["mass"][:, trunk]
    assert mass.min() >= 1.5 - 1e-9 and np.ptp(mass) > 4
    ratio = env.sim.fields["inertia"][:, trunk, 0] / env.sim.model.body_inertia[trunk, 0]
    np.testing.assert_allclose(ratio, mass / env.sim.model.body_mass[trunk])
    others = np.delete(env.sim.fields["mass"], trunk, axis=1)
    assert (np.ptp(others, axis=0) == 0).all()


def test_location_row_moves_the_trunk_s_centre_of_mass():
    env = env_with(trunk_com=0.1)
    trunk = env.sim.model.body("base_link").id
    shift = env.sim.fields["ipos"][:, trunk] - env.sim.model.body_ipos[trunk]
    assert 0.08 < np.abs(shift).max() <= 0.1


def test_friction_row_is_added_to_the_nominal_of_all_soles_of_a_robot():
    env = env_with(friction=(-0.3, 0.5))
    soles = env.sim.soles[env.sim.soles >= 0]
    friction = env.sim.fields["friction"][:, soles, 0]
    assert (np.ptp(friction, axis=1) == 0).all()
    assert 0.5 <= friction.min() < 0.6 and 1.2 < friction.max() <= 1.3


@pytest.mark.parametrize(("row", "half"), [("gain", 0.2), ("gain_absolute", 20.0)])
def test_gain_rows_keep_gain_and_bias_tied(row, half):
    env = env_with(**{row: half})
    gain, bias = env.sim.fields["gain"][:, :, 0], env.sim.fields["bias"][:, :, 1]
    np.testing.assert_allclose(bias, -gain)
    change = gain - env.sim.model.actuator_gainprm[:, 0]
    if row == "gain":
        change = change / env.sim.model.actuator_gainprm[:, 0]
    assert 0.8 * half < np.abs(change).max() <= half + 1e-9
    assert gain.min() >= 0.5 * env.sim.model.actuator_gainprm[:, 0].min()


def test_bias_row_changes_the_bias_alone():
    env = env_with(bias=20.0)
    np.testing.assert_array_equal(
        env.sim.fields["gain"][:, :, 0], np.tile(env.sim.model.actuator_gainprm[:, 0], (N, 1))
    )
    change = env.sim.fields["bias"][:, :, 1] - env.sim.model.actuator_biasprm[:, 1]
    assert 16 < np.abs(change).max() <= 20


def test_strength_row_scales_the_torque_limits_of_a_robot():
    env = env_with(strength=0.1)
    ratio = env.sim.fields["force"] / env.sim.model.actuator_forcerange
    assert (np.ptp(ratio, axis=(1, 2)) < 1e-12).all()
    assert 0.9 <= ratio.min() < 0.92 and 1.08 < ratio.max() <= 1.1


def test_initial_state_row_spreads_the_joints_and_keeps_the_loops_closed():
    spread, same = env_with(initial_joint=0.06), env_with()
    stances = [slice(0, None, 4), *(slice(k, None, 4) for k in (1, 2, 3))]  # 0: the keyframe
    for rows in stances:
        q = spread.pool[0][rows, :][:, spread.sim.at.qpos]
        assert q.std(axis=0).mean() > 0.005
        assert same.pool[0][rows, 7:].std(axis=0).max() < 1e-6


def test_alg_1_delays_a_share_p_of_the_frames_by_up_to_n_delay():
    env = env_with(delay_chance=0.3, delay_steps=3)
    delays = np.stack([env.randomiser.delay() for _ in range(400)])
    assert abs((delays > 0).mean() - 0.3) < 0.02
    assert set(np.unique(delays)) == {0, 1, 2, 3}
    assert (delays.max(axis=0) == env.randomiser.n_delay).all()  # N_delay is the episode's


def test_alg_2_kicks_every_p_int_in_any_direction():
    env = env_with(kick_velocity=0.3, kick_interval=(1.0, 4.0), kick_spread=0.0)
    every = np.ceil(np.round(env.randomiser.kick_every * 60, 6))
    times: list[list[int]] = [[] for _ in range(N)]
    angles = []
    for step in range(1, 600):
        before = env.sim.qvel[:, :2].copy()
        env.randomiser.kick(1 / 60)
        kick = env.sim.qvel[:, :2] - before
        for i in np.flatnonzero(np.abs(kick).max(axis=1) > 0):
            times[i].append(step)
            angles.append(np.arctan2(*kick[i]))
            assert np.linalg.norm(kick[i]) == pytest.approx(0.3)
    for i in range(N):
        assert times[i][0] == pytest.approx(every[i], abs=1)
        assert len(times[i]) >= 2 and np.ptp(np.diff(times[i])) <= 1
    assert np.histogram(angles, 4, (-np.pi, np.pi))[0].min() > 0.15 * len(angles)


def test_the_curriculum_scales_kicks():
    env = env_with(kick_velocity=0.5, kick_interval=(0.01, 0.01), kick_spread=0.0)
    before = env.sim.qvel[:, :2].copy()
    env.randomiser.kick(1 / 60, 0.2)
    np.testing.assert_allclose(np.linalg.norm(env.sim.qvel[:, :2] - before, axis=1), 0.1)


def test_late_actions_are_the_ones_of_the_step_before():
    env = env_with(action_delay=1.0)
    assert env.late.all()
    env.step(np.ones((N, 14)))
    np.testing.assert_allclose(env.sim.ctrl[:, env._ctrl_at], np.tile(env.default, (N, 1)))
