"""Training presets as data: environment, rewards, randomisation, learner."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from mobius.control.observation import FrameKind
from mobius.errors import UnknownName


@dataclass(frozen=True)
class Randomisation:
    """Table III and Algorithms 1 and 2; half-ranges of uniform draws unless said otherwise."""

    orientation: float = 0.0548
    """Roll, pitch, yaw noise of every step [rad] (3.14 deg)."""
    angular_velocity: float = 0.15
    """[rad/s]."""
    linear_velocity: float = 0.05
    """[m/s]."""
    encoder: float = 0.005
    """Joint angle noise [rad]; ours."""
    delay_chance: float = 0.3
    """p of Alg. 1: chance per step that an older frame is observed."""
    delay_steps: int = 2
    """Largest N_delay of Alg. 1 [policy steps]."""
    action_delay: float = 0.5
    """Share of episodes whose targets arrive one policy step late; ours."""
    kick_interval: tuple[float, float] = (1.0, 4.0)
    """Alg. 2 [s]."""
    kick_velocity: float = 0.3
    """Largest kick [m/s]."""
    trunk_mass: tuple[float, float] = (-1.0, 1.5)
    """Added to the trunk [kg]."""
    trunk_com: float = 0.03
    """[m] per axis; Table III's 0.1 m leaves the support of this stance."""
    friction: tuple[float, float] = (-0.3, 0.5)
    """Added to the sole's 0.8."""
    gain: float = 0.2
    """Relative change of every servo's stiffness (gain and bias tied)."""
    initial_joint: float = 0.06
    """Random targets before an episode starts [rad]."""

    def off(self) -> Randomisation:
        """No noise, delay, kick or variation."""
        return Randomisation(
            orientation=0.0,
            angular_velocity=0.0,
            linear_velocity=0.0,
            encoder=0.0,
            delay_chance=0.0,
            action_delay=0.0,
            kick_velocity=0.0,
            trunk_mass=(0.0, 0.0),
            trunk_com=0.0,
            friction=(0.0, 0.0),
            gain=0.0,
            initial_joint=0.0,
        )


@dataclass(frozen=True)
class EnvConfig:
    """The environment of one body."""

    body: str = "crawl"
    frame: FrameKind = "fast"
    history: int = 3
    clock: bool = True
    """Gait clock in the observation (ours)."""
    timestep: float = 1 / 180
    """Physics step [s]."""
    substeps: int = 3
    """Physics steps per policy step."""
    iterations: int = 4
    """Newton iterations."""
    episode_s: float = 20.0
    command_s: tuple[float, float] = (3.0, 7.0)
    """Time between new commands [s]."""
    command_margin: float = 1.15
    """Commands are drawn this much beyond the body's range."""
    min_height: float = 0.16
    """Eq. (3): episode ends below [m]."""
    min_upright: float = 0.6
    """Episode ends when the cosine of the trunk's tilt falls below."""
    velocity_filter_s: float = 0.1
    """Time constant of the velocity the tracking rewards look at [s]."""
    sigma_linear: float = 0.06
    """[m^2/s^2]."""
    sigma_yaw: float = 0.15
    """[rad^2/s^2]."""
    randomisation: Randomisation = field(default_factory=Randomisation)
    weights: dict[str, float] = field(default_factory=dict)
    """Overrides of :data:`mobius.train.rewards.WEIGHTS`; 0 switches a term off."""


@dataclass(frozen=True)
class Preset:
    """A whole training run."""

    env: EnvConfig
    num_envs: int
    steps: int
    """Environment steps in all."""
    horizon: int = 24
    epochs: int = 4
    minibatches: int = 4
    learning_rate: float = 5e-4
    desired_kl: float = 0.02
    gamma: float = 0.98
    lam: float = 0.95
    entropy: float = 0.002
    init_std: float = 0.6
    actor: tuple[int, ...] = (128, 128, 128)
    critic: tuple[int, ...] = (128, 128, 128)

    def algorithm(self) -> dict[str, Any]:
        """rsl_rl's ``algorithm`` table."""
        return dict(
            class_name="PPO",
            num_learning_epochs=self.epochs,
            num_mini_batches=self.minibatches,
            clip_param=0.2,
            gamma=self.gamma,
            lam=self.lam,
            value_loss_coef=1.0,
            entropy_coef=self.entropy,
            learning_rate=self.learning_rate,
            max_grad_norm=1.0,
            schedule="adaptive",
            desired_kl=self.desired_kl,
            use_clipped_value_loss=True,
        )

    def runner(self, actor_class: str) -> dict[str, Any]:
        """rsl_rl's configuration."""
        net = dict(activation="elu", obs_normalization=True)
        return dict(
            num_steps_per_env=self.horizon,
            save_interval=50,
            obs_groups={"actor": ["policy"], "critic": ["policy", "privileged"]},
            algorithm=self.algorithm(),
            actor=dict(
                class_name=actor_class,
                hidden_dims=list(self.actor),
                distribution_cfg=dict(
                    class_name="GaussianDistribution", init_std=self.init_std, std_type="log"
                ),
                **net,
            ),
            critic=dict(class_name="MLPModel", hidden_dims=list(self.critic), **net),
            logger="tensorboard",
        )


_FAST = Preset(EnvConfig(), num_envs=512, steps=4_000_000)

_BIPED = Preset(
    EnvConfig(
        body="biped",
        min_height=0.36,
        min_upright=0.7,
        velocity_filter_s=0.4,
        sigma_linear=0.012,
        sigma_yaw=0.06,
        randomisation=Randomisation(trunk_com=0.02, initial_joint=0.02),
        weights={
            "alive": 0.3,
            "power": -0.002,
            "torque": -0.0003,
            "slip": -0.2,
            "gait": 0.8,
            "swing_height": -0.8,
            "pose": -0.1,
            "stand_still": -0.1,
        },
    ),
    num_envs=512,
    steps=14_000_000,
)

PRESETS: dict[tuple[str, str], Preset] = {
    ("crawl", "fast"): _FAST,
    ("biped", "fast"): _BIPED,
    ("biped", "smoke"): replace(_BIPED, num_envs=32, steps=32 * 24 * 4),
    ("crawl", "smoke"): replace(_FAST, num_envs=32, steps=32 * 24 * 4),
}
"""(body, preset) -> configuration."""


def preset_of(body: str, name: str) -> Preset:
    """The preset ``name`` of ``body``. Raises :class:`UnknownName`."""
    bodies = sorted({b for b, _ in PRESETS})
    if body not in bodies:
        raise UnknownName("body", body, bodies)
    if (body, name) not in PRESETS:
        raise UnknownName("preset", name, [p for b, p in PRESETS if b == body])
    return PRESETS[body, name]
