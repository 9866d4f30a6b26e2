"""What the estimator believes of its sources, as numbers with units."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class FilterNoise:
    """How much the filter trusts its devices and its start. Densities are per root hertz."""

    gyro: float = 4e-4
    """[rad/s/sqrt(Hz)], with the error of integrating at 300 Hz."""
    accel: float = 0.04
    """[m/s^2/sqrt(Hz)]; foot strikes shorter than a sample count for more than the chip."""
    gyro_bias: float = 5e-5
    """Random walk [rad/s/sqrt(s)]."""
    accel_bias: float = 1e-3
    """Random walk [m/s^2/sqrt(s)]."""
    camera_walk: float = 0.01
    """Drift of the camera's position per root metre travelled [m/sqrt(m)]."""
    camera_yaw_walk: float = 0.002
    """Drift of the camera's heading per root metre travelled [rad/sqrt(m)]."""
    gyro_reading: float = 0.003
    """Noise of one reading [rad/s]; only told, in the covariance of ``w_B``."""
    start_tilt: float = 0.02
    """[rad]."""
    start_yaw: float = 0.005
    """[rad]."""
    start_position: float = 0.005
    """[m]."""
    start_velocity: float = 0.05
    """[m/s]."""
    start_gyro_bias: float = 0.005
    """[rad/s]."""
    start_accel_bias: float = 0.05
    """[m/s^2]."""


@dataclass(frozen=True)
class ContactConfig:
    """From force to probability."""

    force: float = 8.0
    """Vertical force [N] at which a limb may as well stand as swing; a quarter of the robot
    weighs 25 N, and a swinging foot feels up to 7 N of its own inertia."""
    hysteresis: float = 1.5
    """A standing limb is let go this far below ``force``, a swinging one caught above [N]."""
    width: float = 1.0
    """Force [N] over which the probability changes e-fold."""
    bandwidth: float = 160.0
    """Of the momentum observer [rad/s]."""
    wrist_bandwidth: float = 300.0
    """Of the wrist force's low-pass [rad/s]."""
    use_wrench: bool = True
    """Arms: believe the wrist sensors; the servo torques where False."""


@dataclass(frozen=True)
class EstimatorConfig:
    """What the estimator believes of its sources."""

    noise: FilterNoise = field(default_factory=FilterNoise)
    contact: ContactConfig = field(default_factory=ContactConfig)
    slip: float = 0.10
    """Leg odometry of one standing limb, one correction, as if white [m/s]: feet that hold."""
    slip_spread: float = 5.0
    """Added to it: this many times the spread [m/s] among the standing limbs' odometries, for
    a foot that slips does so for half a second and 75 corrections, and others with it."""
    slip_time: float = 0.3
    """Time over which that spread is averaged [s]."""
    slip_gate: float = 0.10
    """Speed of a limb's contact point over the ground [m/s] that costs it its weight."""
    lost_gate: float = 5.0
    """A limb off by this many gates is not standing at all."""
    legs_patience: int = 15
    """Corrections in a row with all standing limbs so far off that the velocity is doubted."""
    camera_latency: float = 0.0075
    """Age of the camera's pose when it arrives [s]."""
    camera_position: float = 0.004
    """Noise of the camera's position, horizontal [m]."""
    camera_height: float = 0.01
    """And vertical [m]."""
    camera_tilt: float = 0.3
    """Noise of its roll and pitch, one pose [rad]: 0.5 deg that last 0.5 s and more."""
    camera_yaw: float = 0.12
    """Noise of its yaw, one pose [rad]."""
    camera_jump: float = 0.010
    """How far its heading turns while it is lost [rad]."""
    camera_turn: float = 0.06
    """A camera that comes back turned by more has a new heading [rad]."""
    camera_gap: float = 0.03
    """Silence [s] after which the camera was lost."""
    camera_gate: float = 25.0
    """Squared Mahalanobis distance (6 numbers) beyond which a pose is not used."""
    camera_patience: int = 6
    """Poses in a row beyond the gate after which the camera has jumped."""
    doubt: float = 0.3
    """Added to the spread of the velocity when camera or legs contradict it for long [m/s]."""
    ground: float | None = 0.2
    """Standing limbs are at height zero, noise of one correction [m]; None off flat floors."""
    doubt_height: float = 0.05
    """Added to the spread of the height when the floor is to be believed again [m]."""
    lie_rate: float = 0.10
    """Joint rates below this [rad/s],"""
    lie_turn: float = 0.04
    """rates of the trunk below this [rad/s]"""
    lie_force: float = 0.5
    """and a specific force this close to gravity [m/s^2], all"""
    lie_time: float = 0.15
    """for this long [s], mean that a robot whose limbs are not trusted lies still,"""
    lie_velocity: float = 0.03
    """to within this velocity [m/s]."""
    rest_rate: float = 0.03
    """Joint rates below this, all limbs standing, mean that the robot rests [rad/s]."""
    rest_gyro: float = 0.01
    """How still it rests: noise of one reading of the gyroscope [rad/s]."""
    every: int = 2
    """Frames per correction: 150 Hz. The IMU is integrated, and the belief said, every frame."""
