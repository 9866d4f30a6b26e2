"""Training presets as data: environment, rewards, randomisation, learner."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from mobius.control.observation import FrameKind
from mobius.errors import UnknownName
from mobius.model.poses import Stance
from mobius.paper import BODY_MASS_V3, TABLE_I, TABLE_III
from mobius.train.curriculum import CurriculumConfig
from mobius.train.rewards import OURS
from mobius.train.terrain import TerrainConfig


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
    """P_int of Alg. 2, drawn once an episode [s]."""
    kick_velocity: float = 0.3
    """kick_vel of Alg. 2: largest kick [m/s]."""
    kick_spread: float = 1.0
    """Kicks are this share of the largest smaller at most; 0 makes all the same."""
    trunk_mass: tuple[float, float] = (-1.0, 1.5)
    """Added to the trunk [kg]."""
    trunk_com: float = 0.03
    """[m] per axis; Table III's 0.1 m leaves the support of this stance."""
    friction: tuple[float, float] = (-0.3, 0.5)
    """Added to the sole's 0.8."""
    gain: float = 0.2
    """Relative change of every servo's stiffness (gain and bias tied)."""
    gain_absolute: float = 0.0
    """The same as printed, absolute [N m/rad]; no stiffness falls below half."""
    bias: float = 0.0
    """Change of the bias alone [N m/rad], as printed: it scales the measured angle."""
    strength: float = 0.1
    """Relative change of a robot's torque limits; ours."""
    trunk_floor: float = 1.5
    """No trunk is lighter [kg]."""
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
            gain_absolute=0.0,
            bias=0.0,
            strength=0.0,
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
    ls_iterations: int = 5
    """Line search iterations."""
    weld: bool = True
    """Weld the joints that the policy does not move; physics is a third to a half cheaper."""
    stance: Stance | None = None
    """Stance of the policy instead of the body's keyframe, in which a quarter of the episodes
    begin all the same: it has to get from one to the other."""
    lift: float | None = None
    """Height of a sole in the middle of its swing [m]; None is that of the body's gait."""
    watch_contacts: bool = False
    """Look at the soles after every physics step, not once a policy step, which misses most of
    the touches of a few milliseconds that a foot makes as it leaves the ground."""
    terrain: TerrainConfig | None = None
    """Uneven ground; None is an endless plane."""
    blow_ups: float = 0.0
    """Share of the robots whose simulation may blow up in one step, which then counts as a
    fall; beyond it training stops. On height fields a foot that is caught at an edge can."""
    curriculum: CurriculumConfig = field(default_factory=CurriculumConfig)
    episode_s: float = 20.0
    command_s: tuple[float, float] = (3.0, 7.0)
    """Time between new commands [s]."""
    stand_share: float = 0.1
    """Share of the commands that are zero."""
    command_margin: float = 1.15
    """Commands are drawn this much beyond the body's range."""
    min_height: float = 0.16
    """Eq. (3): episode ends below [m]."""
    min_upright: float = 0.6
    """Episode ends when the cosine of the trunk's tilt falls below."""
    max_joint_speed: float = 0.0
    """Eq. (4): episode ends when a motor turns faster [rad/s]; not in the first 5 steps; 0
    switches it off."""
    limit_margin: float = 0.0
    """Eq. (5): episode ends when a target, before it is clipped, is nearer to a joint limit
    than this [rad]; 0 switches it off."""
    clip_reward: bool = False
    """Sums of rewards below 0 count as 0, as in the tutorial the paper's tables come from."""
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
    warm: str | None = None
    """Preset whose trained run this one starts from (``--from``); None starts from nothing."""
    horizon: int = 24
    epochs: int = 4
    minibatches: int = 4
    learning_rate: float = 5e-4
    desired_kl: float = 0.02
    gamma: float = 0.98
    lam: float = 0.95
    entropy: float = 0.002
    anneal: tuple[int, int] | None = None
    """Steps between which entropy bonus and the largest action noise shrink: exploration that
    stays makes the deterministic policy overshoot its commands."""
    late: tuple[int, dict[str, float]] | None = None
    """Steps from which these weights replace the earlier ones: how it walks is polished once
    it walks."""
    init_std: float = 0.6
    final_std: float = 0.2
    """Largest action noise after ``anneal``."""
    clip: float = 0.2
    value_weight: float = 1.0
    adaptive: bool = True
    """Adapt the learning rate to ``desired_kl``."""
    activation: str = "elu"
    symmetric: bool = True
    """An actor that is left-right equivariant and a critic that is invariant."""
    privileged: bool = True
    """The critic sees the truth, too."""
    actor: tuple[int, ...] = (128, 128, 128)
    critic: tuple[int, ...] = (128, 128, 128)

    def algorithm(self) -> dict[str, Any]:
        """rsl_rl's ``algorithm`` table."""
        return dict(
            class_name="PPO",
            num_learning_epochs=self.epochs,
            num_mini_batches=self.minibatches,
            clip_param=self.clip,
            gamma=self.gamma,
            lam=self.lam,
            value_loss_coef=self.value_weight,
            entropy_coef=self.entropy,
            learning_rate=self.learning_rate,
            max_grad_norm=1.0,
            schedule="adaptive" if self.adaptive else "fixed",
            desired_kl=self.desired_kl,
            use_clipped_value_loss=True,
        )

    def runner(self, actor_class: str) -> dict[str, Any]:
        """rsl_rl's configuration."""
        net = dict(activation=self.activation, obs_normalization=True)
        return dict(
            num_steps_per_env=self.horizon,
            save_interval=50,
            obs_groups={
                "actor": ["policy"],
                "critic": ["policy", "privileged"] if self.privileged else ["policy"],
            },
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


_GROWING = CurriculumConfig(command_start=0.4, command_error=0.35, kick_start=0.2)

WIDE = Stance(arm_r=0.24, arm_turn=0.30, leg_r=0.19, leg_turn=0.20)
"""Where the crawl's policy stands: slower yaw joints, cranks further from their limits
(docs/training.md)."""

_CRAWL = Preset(
    EnvConfig(
        stance=WIDE,
        watch_contacts=True,
        blow_ups=0.01,
        command_margin=1.0,
        sigma_linear=0.08,
        randomisation=Randomisation(kick_velocity=0.25),
        curriculum=_GROWING,
        weights={"tracking_linear": 2.5, "tracking_yaw": 1.2, "tracking_far": 1.0, "pose": -0.02},
    ),
    num_envs=512,
    steps=5_222_400,
    anneal=(3_000_000, 5_000_000),
    late=(
        2_600_000,
        {
            "tracking_linear": 8.0,
            "tracking_far": 4.0,
            "tracking_yaw": 2.0,
            "power": -0.012,
            "joint_speed": -0.15,
            "height": -250.0,
            "vertical_velocity": -3.0,
            "tilt_rate": -0.1,
            "gait": 1.2,
            "scuff": -2.0,
            "swing_height": -1.5,
            "chatter": -30.0,
            "landing": -6.0,
            "impact": -8.0,
            "skim": -6.0,
            "creep": -0.8,
            "fall": -300.0,
            "orientation": -8.0,
        },
    ),
)

_BIPED = Preset(
    EnvConfig(
        body="biped",
        min_height=0.36,
        min_upright=0.7,
        velocity_filter_s=0.4,
        sigma_linear=0.012,
        sigma_yaw=0.06,
        command_margin=1.1,
        stand_share=0.25,
        randomisation=Randomisation(
            trunk_com=0.02, initial_joint=0.02, kick_interval=(1.5, 5.0), kick_velocity=0.8
        ),
        curriculum=CurriculumConfig(kick_start=0.5, kick_falls=4.0),
        weights={
            "alive": 0.3,
            "power": -0.002,
            "torque": -0.0003,
            "slip": -0.2,
            "gait": 1.2,
            "swing_height": -1.0,
            "pose": -0.1,
            "stand_still": -0.1,
            "flat_foot": -8.0,
            "tracking_yaw": 1.5,
        },
    ),
    num_envs=512,
    steps=4_915_200,
    entropy=0.004,
    anneal=(3_000_000, 5_000_000),
    late=(
        3_300_000,
        {
            "tracking_yaw": 2.2,
            "height": -60.0,
            "creep": -5.0,
            "landing": -3.0,
            "scuff": -1.0,
            "chatter": -4.0,
        },
    ),
)


_LOW = {
    "height_band": -80.0,
    "tracking_linear": 10.0,
    "tracking_far": 6.0,
    "tracking_yaw": 4.0,
    "creep": -1.2,
    "chatter": -40.0,
}
"""Late weights of the crawl that learns low swings from nothing, beside those of ``fast``."""

_POLISH = {
    "height_band": -240.0,
    "creep": -2.0,
    "chatter": -90.0,
    "economy": -0.010,
    "fall": -450.0,
    "orientation": -10.0,
}
"""What counts more when the crawl with low swings is polished: the trunk's height, still and
clean feet, power at slow commands, and that it does not go over its hands at its full speed."""

_ROUGH = {
    "crawl": TerrainConfig(),
    "biped": TerrainConfig(bumps=0.04, steps=0.025, slope=0.12),
}


def _late_weights(flat: Preset) -> dict[str, float]:
    return flat.late[1] if flat.late else {}


def _further(flat: Preset, name: str, steps: int, env: EnvConfig) -> Preset:
    """Go on from a run of ``flat``, called ``name``, with its late weights and full commands."""
    env = replace(
        env,
        curriculum=replace(env.curriculum, command_start=1.0, kick_start=1.0),
        weights={**flat.env.weights, **_late_weights(flat), **env.weights},
    )
    anneal = None if flat.anneal is None else (0, steps * 3 // 4)
    return replace(flat, env=env, steps=steps, warm=name, late=None, anneal=anneal)


def _rough(flat: Preset, name: str, steps: int, kicks: float = 1.0) -> Preset:
    """Go on from a flat policy on uneven ground with kicks of ``kicks`` times the size."""
    draw = flat.env.randomisation
    env = replace(
        flat.env,
        terrain=_ROUGH[flat.env.body],
        blow_ups=0.01,
        randomisation=replace(draw, kick_velocity=kicks * draw.kick_velocity),
        weights={},
    )
    return _further(flat, name, steps, env)


def _paper(fast: Preset) -> Preset:
    """Tables I to III to the letter, as far as the physics permits (docs/training.md)."""
    env = EnvConfig(
        body=fast.env.body,
        frame="paper",
        history=16,
        clock=False,
        timestep=1 / 300,
        substeps=5,
        iterations=TABLE_I.solver_iterations,
        ls_iterations=TABLE_I.line_search_iterations,
        weld=False,
        episode_s=TABLE_I.episode_steps / 60,
        command_margin=1.0,
        min_height=fast.env.min_height,
        min_upright=0.0,
        max_joint_speed=TABLE_I.max_motor_speed,
        limit_margin=0.02,
        velocity_filter_s=0.0,
        sigma_linear=0.01 if fast.env.body == "biped" else 0.05,
        sigma_yaw=fast.env.sigma_yaw,
        clip_reward=True,
        randomisation=Randomisation(
            angular_velocity=TABLE_III.yaw_rate.high,
            linear_velocity=TABLE_III.linear_velocity.high,
            encoder=0.0,
            delay_chance=TABLE_III.delay_probability,
            delay_steps=int(TABLE_III.delay_frames.high),
            action_delay=0.0,
            kick_interval=(TABLE_III.kick_interval.low / 60, TABLE_III.kick_interval.high / 60),
            kick_velocity=0.05,
            kick_spread=0.0,
            trunk_mass=(BODY_MASS_V3.low, BODY_MASS_V3.high),
            trunk_com=TABLE_III.body_location.high,
            friction=(TABLE_III.friction.low, TABLE_III.friction.high),
            gain=0.0,
            gain_absolute=TABLE_III.actuator_gain.high,
            strength=0.0,
            initial_joint=0.01,
        ),
        weights={
            **dict.fromkeys(OURS, 0.0),
            "tracking_linear": 1.5,
            "tracking_yaw": 0.8,
            "vertical_velocity": -2.0,
            "tilt_rate": -0.05,
            "power": -0.002,
            "action_rate": -0.01,
            "stand_still": -0.5,
            "air_time": 0.2,
            "contact": 0.1,
            "slip": -0.1,
            "termination": -1.0,
        },
    )
    return Preset(
        env,
        num_envs=8192,
        steps=TABLE_I.steps_flat,
        horizon=20,
        epochs=TABLE_I.updates_per_batch,
        minibatches=TABLE_I.minibatches,
        learning_rate=TABLE_I.learning_rate,
        gamma=TABLE_I.discount,
        entropy=TABLE_I.entropy_cost,
        clip=0.3,
        value_weight=0.5,
        adaptive=False,
        activation="swish",
        symmetric=False,
        privileged=False,
        actor=TABLE_I.hidden_layers,
        critic=(256,) * 5,
    )


def _presets() -> dict[tuple[str, str], Preset]:
    narrow = replace(_CRAWL, env=replace(_CRAWL.env, stance=None))
    presets: dict[tuple[str, str], Preset] = {("crawl", "fast-narrow"): narrow}
    presets["crawl", "fast-low"] = low = replace(
        _CRAWL,
        env=replace(_CRAWL.env, lift=0.028),
        steps=7_602_176,
        anneal=(4_000_000, 7_000_000),
        late=(3_000_000, {**_late_weights(_CRAWL), **_LOW}),
    )
    polished = replace(low.env, lift=0.025, weights=_POLISH)
    presets["crawl", "fast-polish"] = _further(low, "fast-low", 2_400_000, polished)
    presets["crawl", "fast-rough"] = _rough(narrow, "fast-narrow", 3_000_000, kicks=0.5)
    presets["biped", "fast-rough"] = _rough(_BIPED, "fast", 3_000_000, kicks=0.5)
    for body, fast in (("crawl", _CRAWL), ("biped", _BIPED)):
        presets[body, "fast"] = fast
        presets[body, "paper"] = paper = _paper(fast)
        presets[body, "paper-rough"] = _rough(paper, "paper", TABLE_I.steps_rough)
        presets[body, "smoke"] = replace(fast, num_envs=32, steps=32 * 24 * 4)
    return presets


PRESETS = _presets()
"""(body, preset) -> configuration."""


def preset_of(body: str, name: str) -> Preset:
    """The preset ``name`` of ``body``. Raises :class:`UnknownName`."""
    bodies = sorted({b for b, _ in PRESETS})
    if body not in bodies:
        raise UnknownName("body", body, bodies)
    if (body, name) not in PRESETS:
        raise UnknownName("preset", name, [p for b, p in PRESETS if b == body])
    return PRESETS[body, name]
