"""Every number the paper prints, by table and section; nothing else hard-codes one.

The paper is arXiv 2511.01774; the numbers are those of its first version unless a name
says ``V3``. A number stands here as printed. Where the paper contradicts itself, "row n"
points at the same row of ``docs/paper-to-code.md`` and the resolution followed stands
beside the print as ``..._RESOLVED`` or in the field's comment.

Numbers of the robot that the paper does not print (link lengths, servo data) are not
here: they live with the model, with their own sources.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from types import MappingProxyType as _Frozen
from typing import TypeVar

_V = TypeVar("_V")


def _table(**rows: _V) -> Mapping[str, _V]:
    """A read-only table keyed by mode name (a :class:`mobius.types.Mode` works as key)."""
    return _Frozen(rows)


@dataclass(frozen=True)
class Uniform:
    """A uniform distribution as printed: lower end, upper end, unit."""

    low: float
    high: float
    unit: str = ""


@dataclass(frozen=True)
class MeanStd:
    """A measured mean with its printed uncertainty (taken as one standard deviation)."""

    mean: float
    std: float
    unit: str


# --- Sec. I-III: the robot --------------------------------------------------------------

LIMB_NUMBER: Mapping[str, int] = _table(right_arm=0, right_leg=1, left_leg=2, left_arm=3)
"""The paper's limb numbers (Sec. V-G5, Fig. 13), by our names. Row 56: Fig. 20 captions
its curves "0 and 1"; they are the arms, 0 and 3."""

ARM_DOF, LEG_DOF, GRIPPER_FINGERS = 6, 4, 2  # Sec. I-A, III-D

MASS = 10.0
"""Whole robot [kg], Sec. III-A."""
MASS_V3 = 10.3
"""[kg], third version; the model is built for it and accepted from 10.0 to 10.3 kg."""

ARM_TO_LEG_MASS = 1.55
"""Arm mass over leg mass: forearms 55 % heavier than the lower body, Sec. IV-A."""

LIMB_YAW_RANGE_DEG = 210.0
"""Limb yaw workspace, Fig. 3(a)."""
FOOT_PITCH_RANGE_DEG = 105.0
"""Foot pitch workspace, Fig. 3(b), Sec. III-B2."""
ROLL_ANGLE_DEG = 360.0
"""One backward somersault, Sec. III-B3."""


@dataclass(frozen=True)
class LegDesign:
    """Sec. III-C: the leg's five-bar against SCALER's, relative changes."""

    ellipsoid_volume: float = +0.19
    condition_number: float = -0.24


LEG_DESIGN = LegDesign()


@dataclass(frozen=True)
class GearFatigue:
    """Sec. III-D and Fig. 5: Eq. (1) and the two points marked on the S-N curve."""

    K_a: float = 2.0  # application factor
    K_m: float = 1.5  # row 60: the text calls it K_o, Eq. (1) has K_m; all others are 1
    peak_torque: float = 2.5  # [N m] in bipedal locomotion
    leg_stress: float = 496e6  # [Pa] at the peak torque
    leg_life: float = 2.8e5  # [cycles]
    arm_stress: float = 986e6  # [Pa] had the arm's gears carried it
    arm_life: float = 7.2e3  # [cycles]
    arm_module: float = 0.4e-3  # [m]; the leg's larger module is not printed


GEAR_FATIGUE = GearFatigue()

# --- Sec. IV-A: reinforcement learning --------------------------------------------------


@dataclass(frozen=True)
class Training:
    """Table I: simulation and PPO settings."""

    solver_time_step: float = 0.005  # [s]; row 9: no whole number of these makes 1/60 s
    line_search_iterations: int = 3
    solver_iterations: int = 3
    hidden_layers: tuple[int, ...] = (128, 128, 128, 128)
    batch_size: int = 256
    learning_rate: float = 3e-4
    discount: float = 0.97
    entropy_cost: float = 1e-2
    minibatches: int = 32
    updates_per_batch: int = 4
    steps_flat: int = 300_000_000
    steps_rough: int = 100_000_000
    episode_steps: int = 2000  # row 8: reaching it truncates, it does not terminate
    max_motor_rpm: float = 50.0  # row 6: any motor beyond it, either direction
    action_scale: float = 0.3  # a_scale of Eq. (2) [rad]

    @property
    def max_motor_speed(self) -> float:
        """Table I's rpm limit in [rad/s]."""
        return self.max_motor_rpm * 2 * pi / 60


TABLE_I = Training()


@dataclass(frozen=True)
class Observation:
    """Sec. IV-A2: sizes of the observation and the action of one policy.

    Row 1: the trunk state is printed as 10 numbers but lists 7, and only 7 give the
    printed totals. One frame is trunk, joint angles, last action, velocity command, yaw
    command; the policy sees the current frame and ``history`` past ones.
    """

    joints: int
    printed_total: int
    trunk: int = 7  # roll, pitch, yaw, yaw rate, vx, vy, vz
    trunk_printed: int = 10
    command: int = 3  # vx, vy, yaw rate
    history: int = 15  # N

    @property
    def frame(self) -> int:
        """Numbers in one frame."""
        return self.trunk + 2 * self.joints + self.command

    @property
    def total(self) -> int:
        """Numbers the policy sees."""
        return self.frame * (self.history + 1)


OBSERVATION = _table(biped=Observation(8, 416), crawl=Observation(14, 608))
"""Biped: 4 joints per leg. Crawl (row 4): 3 per leg, the ankle held, and 4 per arm."""


@dataclass(frozen=True)
class Rewards:
    """Table II: the eleven terms, by our names in printed order, and the numbers inside.

    Weights and sigma are not printed. Rows 10-17 resolve signs, squares and gates.
    """

    terms: tuple[str, ...] = (
        "vertical_velocity",  # v_z^2
        "tilt_rate",  # |w_xy|^2
        "power",  # sum |tau| |w|, printed as "joint torques"
        "action_rate",  # row 10: sum of squares; printed without the square
        "tracking_linear",  # exp(-|v_des - v|^2 / sigma)
        "tracking_yaw",  # exp(-|w_des - w|^2 / sigma)
        "stand_still",  # row 11: a penalty, though called a reward
        "air_time",  # row 13: counted at first contact
        "contact",  # row 14
        "slip",  # row 12: foot velocity; printed with the position
        "termination",
    )
    stand_gate: float = 0.1  # [m/s] commanded speed below which to stand; row 16
    move_gate: float = 0.05  # [m/s] above which air time and slip count; row 16
    contact_time: float = 0.10  # [s]
    early_steps: int = 500  # a fall before this step is punished; row 17


TABLE_II = Rewards()


@dataclass(frozen=True)
class Randomization:
    """Table III: noise and domain randomisation, as printed."""

    orientation: Uniform = Uniform(-pi, pi, "deg")  # row 18: taken literally, +-0.055 rad
    yaw_rate: Uniform = Uniform(-0.15, 0.15, "rad/s")
    linear_velocity: Uniform = Uniform(-0.05, 0.05, "m/s")
    initial_joints: Uniform = Uniform(0.01, 0.01, "deg")  # row 20
    delay_frames: Uniform = Uniform(1, 3, "frames")  # row 24: N_delay of Alg. 1
    delay_probability: float = 0.3
    kick_interval: Uniform = Uniform(10, 30, "steps")  # row 25
    kick_angle: Uniform = Uniform(0, 2 * pi, "deg")  # row 19: radians
    body_mass: Uniform = Uniform(5.0, 5.0, "kg")  # row 21
    body_location: Uniform = Uniform(-0.1, 0.1, "m")
    friction: Uniform = Uniform(-0.3, 0.5, "")  # row 22: added to the nominal
    actuator_gain: Uniform = Uniform(-20, 20, "N m/rad")  # row 23: gain and bias tied
    actuator_bias: Uniform = Uniform(-20, 20, "N m/rad")


TABLE_III = Randomization()
INITIAL_JOINTS_RESOLVED = Uniform(-0.01, 0.01, "rad")
"""Row 20: both printed ends are equal, and 0.01 deg is no disturbance at all."""
BODY_MASS_V3 = Uniform(-5.0, 5.0, "kg")
"""Row 21: the third version's correction of Table III, added to the trunk."""

MPC_STATES = 12
"""X_ref of Sec. IV-B2: orientation, position, angular and linear velocity."""

# --- Sec. IV-D, IV-E, V-A: rates --------------------------------------------------------


@dataclass(frozen=True)
class Rates:
    """Sec. IV-D, IV-E and V-A [Hz]. Row 61: a 600 Hz clock divides them all."""

    policy: int = 60
    motors: int = 300
    admittance: int = 300
    optistate: int = 300
    visual_servo: int = 300
    open_loop: int = 300
    vio: int = 200
    detector: int = 30


RATES = Rates()


@dataclass(frozen=True)
class VisualServo:
    """Sec. IV-E and V-G5. Row 55: the printed damping is that of the PID polynomial."""

    K_p: float = 3.0
    K_i: float = 4.5
    K_d: float = 1.0
    damping: float = 0.7
    rise_time: float = 0.5  # [s], 10 % to 90 %
    settling_time: float = 1.75  # [s]
    disturbance_time: float = 1.2  # [s] the spike of Fig. 20
    annotated_images: int = 200


VISUAL_SERVO = VisualServo()

# --- Sec. IV-F, V-F: planning -----------------------------------------------------------

STEPS: Mapping[str, tuple[int, ...]] = _table(biped=(-1, 1), crawl=(-2, -1, 1, 2), roll=(-3, 3))
"""Cells a mode may move in one step, Table IV (8)-(10). Row 39: along one axis."""
MODE_NUMBER: Mapping[str, int] = _table(biped=1, crawl=2, roll=3)
"""Index of m_k, P_k and of the labels of Fig. 12."""
CELL = 0.5
"""Edge of a grid cell [m], Sec. V-F."""
MAP_EDGE = 20.0
"""[m], Sec. V-A. Row 48: read as 20 cells, 10 m, by default."""
MAP_HORIZON = 20
"""T, Sec. V-A, there called seconds. Row 48: planner steps."""
SOLVE_TIME_S = (10.0, 11.0)
"""Printed range of the solver's time, Sec. V-A."""
MODE_SWITCH_RATE = 0.25
"""Share of steps that change mode, Sec. V-F."""

MAX_SPEED: Mapping[str, float] = _table(biped=0.1, crawl=0.4, roll=0.7)
"""Table V [m/s]."""
MAX_YAW_RATE: Mapping[str, float] = _table(biped=0.25, crawl=0.6)
"""[rad/s], Sec. V-B and V-C."""
ROLL_FASTER_PERCENT: Mapping[str, float] = _table(biped=600.0, crawl=133.33)
"""Sec. V-D. Row 53: against 0.4 m/s it is 75 %; 133.33 % would need 0.3 m/s."""


@dataclass(frozen=True)
class PlanRow:
    """One row of Table VI. Row 44: the goal weight is printed negative, used as a penalty."""

    W_exp: float
    W_goal: float
    epsilon: float
    M: float
    T: int
    seconds: float
    energy: float  # [J] per visited cell; row 50
    switch_rate: float | None = None
    failures: int | None = None  # of PLAN_COMBINATIONS


TABLE_VI_MULTI = (
    PlanRow(20, -20, 1e-4, 1000, 20, 10.67, 34.91, switch_rate=0.27),
    PlanRow(200, -200, 1e-2, 16000, 20, 11.20, 35.41, switch_rate=0.22),
)
"""Table VI, top: all modes. Row 47: these weights are not among those of Table VII."""
TABLE_VI_SINGLE: Mapping[str, PlanRow] = _table(
    biped=PlanRow(100, -50, 1e-3, 8000, 40, 78.86, 26.89, failures=270),
    crawl=PlanRow(50, -1, 1e-3, 8000, 20, 4.16, 5.11, failures=160),
    roll=PlanRow(1, -1, 1e-3, 8000, 15, 1.73, 21.96, failures=135),
)
"""Table VI, bottom: one mode at a time. Row 49: the text swaps biped and roll; the table
agrees with the third version."""
TEXT_V_F_ENERGY: Mapping[str, float] = _table(biped=21.96, crawl=5.11, roll=26.89)
"""[J/cell] as the text of Sec. V-F has them; see row 49, not to be used."""
COST_OF_TRANSPORT_V3: Mapping[str, float] = _table(biped=0.548, crawl=0.104, roll=0.448)
"""Third version: energy per cell over 10 kg * g * 0.5 m."""


@dataclass(frozen=True)
class PlanSweep:
    """Table VII: the grid of planner settings."""

    W_exp: tuple[float, ...] = (1, 50, 100)
    W_goal: tuple[float, ...] = (-1, -50, -100)
    epsilon: tuple[float, ...] = (1e-4, 1e-3, 1e-2)
    M: tuple[float, ...] = (1000, 8000, 16000)
    T: tuple[int, ...] = (10, 15, 20, 40)


TABLE_VII = PlanSweep()
PLAN_COMBINATIONS = 324
"""Table VI. Row 47: this counts T; with T fixed, as the top half says, 81 remain."""


@dataclass(frozen=True)
class MetreEnergy:
    """One row of Table VIII [J/m]. Row 51: not reproducible physics, not a target."""

    kinetic: float
    potential: float
    total: float


TABLE_VIII: Mapping[str, MetreEnergy] = _table(
    biped=MetreEnergy(1.35, 102.82, 104.17),
    crawl=MetreEnergy(6.00, 58.86, 64.86),
    roll=MetreEnergy(15.00, 0.00, 3.00),
    pull_up=MetreEnergy(3.00, 58.86, 61.86),
    climb=MetreEnergy(0.60, 294.30, 294.90),
)
TABLE_VIII_ROLL_V3 = MetreEnergy(70.0, 0.0, 70.0)
"""Row 51: the third version's correction; only this one adds up."""
COM_HEIGHT: Mapping[str, float] = _table(biped=0.35, crawl=0.20)
"""Caption of Table VIII [m]."""

# --- Sec. V-B to V-G: experiments -------------------------------------------------------


@dataclass(frozen=True)
class Push:
    """Sec. V-B, Fig. 16: velocity impulse on the trunk at which standing fails."""

    duration: float = 0.1  # [s]; row 26
    mpc_fails: float = 0.05  # [m/s]
    policy_fails: float = 0.25  # [m/s]


PUSH = Push()

FIG_17_SIDEWAYS_S = (-0.1, 0.0)
"""Target (x, y) [m/s] of the biped's sideways walk, in the paper's frame (y forward)."""

TABLE_IX: Mapping[str, MeanStd] = _table(
    x=MeanStd(23.6, 4.1, "N"),
    z=MeanStd(124.2, 24.5, "N"),
)
"""Greatest force one closed gripper holds on an aluminium bar: x along the groove, z
across it. Row 57: not the axes of Fig. 15. Row 59: z is only 1.27 weights."""


@dataclass(frozen=True)
class SlideClimb:
    """Sec. V-G1, Fig. 14."""

    trials: int = 10
    successes: int = 8
    first_step_time: float = 3.0  # [s]
    first_regrasp_time: float = 8.0  # [s]
    release_time: float = 110.0  # [s]


SLIDE_CLIMB = SlideClimb()


@dataclass(frozen=True)
class PullUp:
    """Sec. V-G4, Fig. 15, axes of the gripper/handle frame (row 57)."""

    force_error_reduction: float = 0.45  # by tuning the admittance gains
    normal_moment: tuple[float, float] = (-3.0, 5.0)  # [N m]
    reference: tuple[float, float, float] = (-0.15, 0.30, -0.12)  # x, y, z [m]
    disturbance: float = 15.0  # [N] downwards
    successes_v3: int = 9  # of 10, later versions


PULL_UP = PullUp()


@dataclass(frozen=True)
class Governor:
    """Sec. V-G4, Fig. 19: the reference governor. The limits themselves are not printed."""

    violations_without: tuple[float, ...] = (0.0, 2.5)  # [s]; later versions add 10.0
    unmodified: tuple[float, float] = (10.0, 17.5)  # [s] reference left nearly alone


GOVERNOR = Governor()
