"""Rewards of Table II and our additions: small pure functions over n robots.

Each takes :class:`Signals` and returns (n,). The environment multiplies the weighted sum
by the policy period (1/60 s). Signs are in the weights.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius import paper

Array = NDArray[np.float64]
MAX_SPEED = paper.TABLE_I.max_motor_speed
"""50 rpm [rad/s] (Table I)."""

HEIGHT_BAND = 0.02
"""Half the band in which the trunk's height costs nothing extra [m]."""

ECONOMY_SPEEDS = (0.45, 0.60)
"""Commands up to the first [m/s] pay in full for ``economy``, from the second on nothing."""

SKIM_HEIGHT = 0.012
"""A foot lower than this [m] skims."""


@dataclass
class Signals:
    """What the rewards look at after one policy step; n robots, k joints, f feet."""

    command: Array
    """(n, 3) vx, vy [m/s], wz [rad/s]."""
    moving: Array
    """(n,) 1 where the command is above the stand-still gate."""
    swing: Array
    """(n, f) what the gait clock wants: 0 on the ground, up to 1 in the middle of a swing."""
    contact_wanted: Array
    """(n, f) what the gait clock wants: 1 on the ground, -1 in the air, 0 either."""
    velocity: Array
    """(n, 3) filtered vx, vy [m/s], wz [rad/s] in the heading frame."""
    v_z: Array
    """(n,) [m/s]."""
    w_xy: Array
    """(n, 2) roll and pitch rate [rad/s]."""
    gravity_xy: Array
    """(n, 2) horizontal part of unit gravity in the heading-aligned trunk frame."""
    height_error: Array
    """(n,) trunk height minus that of the stance [m]."""
    q_error: Array
    """(n, k) joint angle minus default [rad]."""
    torque: Array
    """(n, m) [N m] of all servos that move."""
    speed: Array
    """(n, m) [rad/s]."""
    torque_limit: Array
    """(m,) stall torque [N m]."""
    action: Array
    """(n, k)."""
    action_1: Array
    """(n, k) one step earlier."""
    action_2: Array
    """(n, k) two steps earlier."""
    contact: Array
    """(n, f) 1 in contact."""
    touching: Array
    """(n, f) share of the looks since the last policy step that saw it in contact."""
    touchdown: Array
    """(n, f) 1 at the first step of a contact."""
    air_time: Array
    """(n, f) [s] airborne until now, or until the touchdown of this step."""
    contact_time: Array
    """(n, f) [s] in contact until now."""
    foot_height: Array
    """(n, f) sole above the floor [m]."""
    foot_speed: Array
    """(n, f) horizontal [m/s]."""
    landing_speed: Array
    """(n, f) vertical, one step before [m/s]."""
    landing_drag: Array
    """(n, f) horizontal speed, one step before [m/s]."""
    lifted_early: Array
    """(n, f) how many contacts of less than 0.08 s ended since the last policy step."""
    foot_tilt: Array
    """(n, f) squared sine of a sole's tilt."""
    fallen: Array
    """(n,) 1 where the episode ends by a fall."""
    early: Array
    """(n,) 1 before step 500."""
    swing_top: float
    """Height that a sole should have in the middle of a swing [m]."""
    sigma_linear: float
    sigma_yaw: float


def tracking_linear(s: Signals) -> Array:
    """R_vxy: exp(-|v_des - v|^2 / sigma)."""
    e = s.command[:, :2] - s.velocity[:, :2]
    return np.exp(-np.sum(e * e, axis=1) / s.sigma_linear)


def tracking_yaw(s: Signals) -> Array:
    """R_wz: exp(-(w_des - w)^2 / sigma)."""
    e = s.command[:, 2] - s.velocity[:, 2]
    return np.exp(-e * e / s.sigma_yaw)


def vertical_velocity(s: Signals) -> Array:
    """R_vz [m^2/s^2]."""
    return s.v_z**2


def tilt_rate(s: Signals) -> Array:
    """R_wxy [rad^2/s^2]."""
    return np.sum(s.w_xy**2, axis=1)


def power(s: Signals) -> Array:
    """R_tau: mechanical power, sum |tau w| [W]."""
    return np.sum(np.abs(s.torque * s.speed), axis=1)


def action_rate(s: Signals) -> Array:
    """R_a, squared (row 10)."""
    return np.sum((s.action - s.action_1) ** 2, axis=1)


def stand_still(s: Signals) -> Array:
    """R_stand: joint deviation while the command is zero [rad]."""
    return np.sum(np.abs(s.q_error), axis=1) * (1.0 - s.moving)


def air_time(s: Signals) -> Array:
    """R_air: (T_air - 0.1 s), at most 0.3 s, paid at touchdown while commanded to move."""
    paid = np.clip(s.air_time - 0.10, -0.1, 0.3) * s.touchdown
    return np.sum(paid, axis=1) * s.moving


def contact(s: Signals) -> Array:
    """R_contact: feet whose contact has lasted 0.1 s, while commanded to move."""
    return np.sum(s.contact * (s.contact_time >= 0.10), axis=1) * s.moving


def slip(s: Signals) -> Array:
    """R_slip: squared speed of feet in contact [m^2/s^2]."""
    return np.sum(s.foot_speed**2 * s.contact, axis=1)


def termination(s: Signals) -> Array:
    """R_term: a fall before step 500."""
    return s.fallen * s.early


# Ours: not in Table II.


def fall(s: Signals) -> Array:
    """Any fall."""
    return s.fallen


def tracking_far(s: Signals) -> Array:
    """exp(-|v_des - v| / 0.4 m/s): pulls from far away, where R_vxy is flat."""
    return np.exp(-np.linalg.norm(s.command[:, :2] - s.velocity[:, :2], axis=1) / 0.4)


def joint_speed(s: Signals) -> Array:
    """Squared joint speed beyond 85 % of 50 rpm [rad^2/s^2]."""
    return np.sum(np.maximum(np.abs(s.speed) - 0.85 * MAX_SPEED, 0.0) ** 2, axis=1)


def alive(s: Signals) -> Array:
    """Constant 1."""
    return np.ones(len(s.v_z))


def orientation(s: Signals) -> Array:
    """Squared sine of the trunk's tilt."""
    return np.sum(s.gravity_xy**2, axis=1)


def height(s: Signals) -> Array:
    """Squared height error, at most (0.1 m)^2."""
    return np.minimum(s.height_error**2, 0.01)


def height_band(s: Signals) -> Array:
    """Height error beyond HEIGHT_BAND [m]: the square of ``height`` hardly feels the last
    centimetre.
    """
    return np.maximum(np.abs(s.height_error) - HEIGHT_BAND, 0.0)


def economy(s: Signals) -> Array:
    """Mechanical power [W] at commands up to about the paper's 0.4 m/s: a higher price of
    ``power`` at every speed makes a policy too slow at its fastest, where the servos leave no
    choice.
    """
    slow, fast = ECONOMY_SPEEDS
    asked = np.linalg.norm(s.command[:, :2], axis=1)
    return power(s) * np.clip((fast - asked) / (fast - slow), 0.0, 1.0)


def torque(s: Signals) -> Array:
    """Sum of squared torques [N^2 m^2]."""
    return np.sum(s.torque**2, axis=1)


def saturation(s: Signals) -> Array:
    """Torque beyond 80 % of stall, as a share of stall."""
    return np.sum(np.maximum(np.abs(s.torque) / s.torque_limit - 0.8, 0.0), axis=1)


def action_acceleration(s: Signals) -> Array:
    """Squared second difference of the actions."""
    return np.sum((s.action - 2 * s.action_1 + s.action_2) ** 2, axis=1)


def pose(s: Signals) -> Array:
    """Squared joint deviation from the stance [rad^2]."""
    return np.sum(s.q_error**2, axis=1)


def gait(s: Signals) -> Array:
    """Feet that do what the clock wants minus feet that do not, as a mean in [-1, 1]."""
    does = s.contact_wanted * (2.0 * s.contact - 1.0)
    return np.mean(np.where(s.contact_wanted == 0, 1.0, does), axis=1)


def scuff(s: Signals) -> Array:
    """Feet in contact that should be in the air, each by the share of the height it should
    have.
    """
    return np.sum(s.swing * s.touching, axis=1)


def swing_height(s: Signals) -> Array:
    """Squared relative miss of the swing height, at most 1 a foot, over swinging feet."""
    miss = np.clip(s.foot_height / s.swing_top - s.swing, -1.0, 1.0)
    return np.mean(miss**2 * (s.swing > 0), axis=1)


def impact(s: Signals) -> Array:
    """Squared vertical speed with which feet land [m^2/s^2]."""
    return np.sum(s.touchdown * s.landing_speed**2, axis=1)


def landing(s: Signals) -> Array:
    """Squared horizontal speed with which feet land [m^2/s^2]: a foot that does not meet the
    ground at the ground's speed drags and rattles.
    """
    return np.sum(s.touchdown * s.landing_drag**2, axis=1)


def skim(s: Signals) -> Array:
    """Squared horizontal speed of feet [m^2/s^2], fading out with their height: a foot should be
    up before it moves on, and at rest before it lands.
    """
    near = np.clip(1.0 - s.foot_height / SKIM_HEIGHT, 0.0, 1.0)
    return np.sum(s.foot_speed**2 * near, axis=1)


def creep(s: Signals) -> Array:
    """Speed of feet in contact [m/s]; unlike ``slip`` it does not forgive what is slow."""
    return np.sum(s.foot_speed * s.contact, axis=1)


def chatter(s: Signals) -> Array:
    """Contacts of less than 0.08 s that end."""
    return np.sum(s.lifted_early, axis=1)


def flat_foot(s: Signals) -> Array:
    """Squared sine of the tilt of soles in contact."""
    return np.sum(s.foot_tilt * s.contact, axis=1)


TERMS: dict[str, Callable[[Signals], Array]] = {
    f.__name__: f
    for f in (
        tracking_linear,
        tracking_yaw,
        vertical_velocity,
        tilt_rate,
        power,
        action_rate,
        stand_still,
        air_time,
        contact,
        slip,
        termination,
        fall,
        tracking_far,
        joint_speed,
        alive,
        orientation,
        height,
        height_band,
        economy,
        torque,
        saturation,
        action_acceleration,
        pose,
        gait,
        scuff,
        swing_height,
        flat_foot,
        impact,
        landing,
        skim,
        creep,
        chatter,
    )
}

OURS: tuple[str, ...] = tuple(k for k in TERMS if k not in paper.TABLE_II.terms)
"""Terms that Table II does not have."""

WEIGHTS: dict[str, float] = {
    "tracking_linear": 1.5,
    "tracking_yaw": 0.75,
    "vertical_velocity": -1.0,
    "tilt_rate": -0.05,
    "power": -0.007,
    "action_rate": -0.006,
    "stand_still": -0.15,
    "air_time": 0.0,
    "contact": 0.0,
    "slip": -0.4,
    "termination": -1.0,
    "fall": -10.0,
    "tracking_far": 0.0,
    "joint_speed": -0.05,
    "alive": 0.1,
    "orientation": -3.0,
    "height": -20.0,
    "height_band": 0.0,
    "economy": 0.0,
    "torque": -0.0004,
    "saturation": -0.2,
    "action_acceleration": -0.003,
    "pose": -0.05,
    "gait": 0.6,
    "scuff": 0.0,
    "swing_height": -1.2,
    "flat_foot": 0.0,
    "impact": -2.0,
    "chatter": -2.0,
    "landing": 0.0,
    "skim": 0.0,
    "creep": 0.0,
}
"""Default weights of the crawl; a weight of 0 switches a term off."""


def total(signals: Signals, weights: dict[str, float]) -> tuple[Array, dict[str, float]]:
    """Weighted sum (n,) and the mean of every term that counts."""
    reward = np.zeros(len(signals.v_z))
    means: dict[str, float] = {}
    for name, weight in weights.items():
        if weight:
            value = weight * TERMS[name](signals)
            reward += value
            means[name] = float(np.add.reduce(value)) / len(value)  # twice as quick as mean()
    return reward, means
