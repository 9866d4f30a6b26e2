"""How well a body follows velocity commands, and how well it moves while it does (Fig. 17)."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import body_of
from mobius.errors import InvalidInput
from mobius.evaluate.commands import AXES, NAMED, STRAIGHT, Segment, schedule
from mobius.evaluate.episode import HOLD_S, SETTLE_S, WINDOW_S, Episode, Policy, Setup, drive
from mobius.evaluate.gauge import Readings
from mobius.evaluate.jobs import Progress, run_jobs
from mobius.model.joints import JOINTS

Array = NDArray[np.float64]

COMMANDS = 5
"""Commands in an episode."""
STILL_AFTER_S = 1.5
"""Stillness counts from this long after the command to stand [s]."""
LEAST_WAY = 0.1
"""Slip is no share of a shorter way than this [m]."""


@dataclass
class SegmentScore:
    """What one command of one episode came to; None where nothing counted."""

    name: str
    target: list[float]
    """vx, vy [m/s], wz [rad/s]."""
    mean: list[float] | None
    """True mean velocity."""
    mae: list[float] | None
    """Mean |mean over a stride - target|."""
    power_W: float | None
    fallen: bool
    height_error_m: float | None = None
    """Largest deviation of the trunk's height from the stance's [m]."""
    slid_m: float = 0.0
    """Path slid on the ground, mean over feet; counted where it goes straight on [m]."""
    distance_m: float = 0.0
    """Way of the trunk meanwhile [m]."""
    still_s: float = 0.0
    """How long stillness was watched [s]."""
    joint_speed_rms: float = 0.0
    """Of the 20 limb joints while standing [rad/s]."""
    lifts: int = 0
    """Feet lifted while standing."""


@dataclass
class Run:
    """One episode of one seed."""

    seed: int
    fallen: bool
    error: list[float]
    """Mean absolute error of vx, vy [m/s], wz [rad/s] over means over a stride."""
    raw_error: list[float]
    """The same without averaging."""
    estimate_error: list[float]
    """RMS of believed minus true vx, vy [m/s], wz [rad/s]."""
    power_W: float
    saturation: float
    """Share of joint-samples whose output torque exceeds 95 % of stall."""
    max_dq_rpm: float
    torque_peak: list[float]
    """(20,) largest torque per joint as a share of its torque-speed line."""
    height_error_m: float
    """Largest deviation of the trunk's height from the stance's [m]."""
    loop_residual_mm: float
    contacts: int
    """Contacts that were seen from beginning to end."""
    chatter: int
    """How many of them were shorter than 0.05 s."""
    segments: list[SegmentScore] = field(default_factory=list)


def score_segment(episode: Episode, k: int) -> SegmentScore:
    """Segment ``k`` of an episode."""
    segment, t = episode.segments[k], episode.rows["t"]
    since, mine = episode.since(t), episode.segment_at(t) == k
    margin = 0.5 * WINDOW_S
    rows = mine & (since > SETTLE_S) & (since < episode.hold_s - margin) & (t <= t[-1] - margin)
    readings = episode.readings
    held = episode.since(readings.t)
    looks = (episode.segment_at(readings.t) == k) & (held > SETTLE_S)
    score = SegmentScore(
        name=segment.name,
        target=list(segment.twist),
        mean=None,
        mae=None,
        power_W=float(readings.power()[looks].mean()) if looks.any() else None,
        fallen=episode.fell_in == k,
        height_error_m=readings.height_error(looks) if looks.any() else None,
    )
    if rows.any():
        score.mean = _floats(episode.rows["true_twist_H"][rows].mean(axis=0))
        score.mae = _floats(np.abs(episode.smooth[rows] - segment.twist).mean(axis=0))
    if segment.name in STRAIGHT:
        score.slid_m, score.distance_m = readings.slip(looks)
    if segment.name == "stand":
        _watch_stillness(score, readings, looks & (held > STILL_AFTER_S))
    return score


def _watch_stillness(score: SegmentScore, readings: Readings, rows: NDArray[np.bool_]) -> None:
    if rows.any():
        score.still_s = float(np.ptp(readings.t[rows]))
        score.joint_speed_rms = float(np.sqrt(np.mean(readings.dq[rows] ** 2)))
        score.lifts = readings.lifts(rows)


def _floats(values: Array) -> list[float]:
    return [float(v) for v in values]


def measure(seed: int, episode: Episode) -> Run:
    """All figures of one episode."""
    readings = episode.readings
    short, contacts = readings.chatter(after_s=SETTLE_S)
    last = len(episode.segments) if episode.fell_in is None else episode.fell_in + 1
    return Run(
        seed=seed,
        fallen=episode.fallen,
        error=_floats(episode.error()),
        raw_error=_floats(episode.raw_error()),
        estimate_error=_floats(episode.estimate_error()),
        power_W=float(readings.power().mean()),
        saturation=readings.saturation(),
        max_dq_rpm=readings.max_dq_rpm(),
        torque_peak=_floats(readings.torque_peak()),
        height_error_m=readings.height_error(),
        loop_residual_mm=1e3 * episode.loop_residual,
        contacts=contacts,
        chatter=short,
        segments=[score_segment(episode, k) for k in range(last)],
    )


def track(setup: Setup, *, segments: list[Segment], hold_s: float = HOLD_S) -> Run:
    """One episode: drive and measure."""
    return measure(setup.seed, drive(setup, segments, hold_s=hold_s))


def _track(setup: Setup, *, speed: float) -> Run:
    return track(setup, segments=schedule(setup.body, setup.seed, count=COMMANDS, speed=speed))


@dataclass
class Tracking:
    """The outcome of ``mobius eval BODY tracking``."""

    body: str
    seed: int
    """The first seed."""
    speed: float
    """Factor on all commands."""
    episodes: int
    falls: int
    mae: dict[str, float]
    """vx, vy [m/s], wz [rad/s]; mean over episodes of the error of means over a stride."""
    mae_raw: dict[str, float]
    """The same without averaging."""
    commands: dict[str, dict[str, Any]]
    """Per command: target, mean, mae (3 numbers each), falls, segments, power_W, height_error_m
    (the largest) and, where it goes straight on, slip_fraction."""
    stand: dict[str, Any]
    """While standing: segments, joint_speed_rms [rad/s], foot_lifts_per_s."""
    slip_fraction: float | None
    """Path that the feet slid on the ground over the way of the trunk, straight on."""
    chatter_fraction: float | None
    """Share of contacts shorter than 0.05 s."""
    max_dq_rpm: float
    """Fastest joint; of episodes without a fall, if there are any."""
    torque_peak: dict[str, float]
    """Largest torque per joint as a share of its torque-speed line; likewise."""
    power_W: float
    saturation: float
    height_error_m: float
    """Largest deviation of the trunk's height from the stance's; likewise."""
    height_error_p95_m: float
    """95th percentile over episodes of their largest; likewise."""
    loop_residual_mm: float
    """Largest of all episodes."""
    estimate_rmse: dict[str, float]
    runs: list[Run] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def tracking(
    body: str,
    *,
    seeds: int,
    seed: int = 0,
    policy: Policy = None,
    randomised: bool = True,
    speed: float = 1.0,
    workers: int = 0,
    progress: Progress | None = None,
) -> Tracking:
    """Follow five of eight commands a seed, 4 s each, and measure tracking and motion.

    Args:
        body: ``crawl`` or ``biped``.
        seeds: Number of episodes, >= 1.
        seed: First seed.
        policy: What drives; the shipped policy if not given.
        randomised: Draw friction, mass, servos, delay and sensors.
        speed: Factor on all commands, > 0.
        workers: Processes; 0 takes one a CPU.
        progress: Called with the share done after each episode.
    """
    body_of(body)
    if not speed > 0:
        raise InvalidInput(f"tracking: expected a speed factor > 0, got {speed}")
    setups = [Setup(body, seed + k, policy, randomised) for k in range(seeds)]
    runs = run_jobs(partial(_track, speed=speed), setups, workers=workers, progress=progress)
    return summarise(body, seed, speed, runs)


def summarise(body: str, seed: int, speed: float, runs: list[Run]) -> Tracking:
    """Means over episodes; of peaks the largest; slip and chatter over all ways and contacts."""
    upright = [r for r in runs if not r.fallen] or runs
    contacts = sum(r.contacts for r in runs)
    segments = [s for r in runs for s in r.segments]
    peaks = np.max([r.torque_peak for r in upright], axis=0)

    def mean(name: str) -> dict[str, float]:
        values = np.mean([getattr(r, name) for r in runs], axis=0)
        return dict(zip(AXES, _floats(values), strict=True))

    return Tracking(
        body=body,
        seed=seed,
        speed=speed,
        episodes=len(runs),
        falls=sum(r.fallen for r in runs),
        mae=mean("error"),
        mae_raw=mean("raw_error"),
        commands={n: per_command([s for s in segments if s.name == n]) for n in NAMED},
        stand=stillness([s for s in segments if s.still_s > 0]),
        slip_fraction=slip_fraction(segments),
        chatter_fraction=sum(r.chatter for r in runs) / contacts if contacts else None,
        max_dq_rpm=max(r.max_dq_rpm for r in upright),
        torque_peak=dict(zip(JOINTS, _floats(peaks), strict=False)),
        power_W=float(np.mean([r.power_W for r in runs])),
        saturation=float(np.mean([r.saturation for r in runs])),
        height_error_m=max(r.height_error_m for r in upright),
        height_error_p95_m=float(np.percentile([r.height_error_m for r in upright], 95)),
        loop_residual_mm=max(r.loop_residual_mm for r in runs),
        estimate_rmse=mean("estimate_error"),
        runs=runs,
    )


def per_command(scores: list[SegmentScore]) -> dict[str, Any]:
    """What one command came to over all its segments."""

    def mean(name: str) -> Any:
        values = [v for s in scores if (v := getattr(s, name)) is not None]
        return np.mean(values, axis=0).tolist() if values else None

    row = {name: mean(name) for name in ("target", "mean", "mae")}
    counts = {"falls": sum(s.fallen for s in scores), "segments": len(scores)}
    slip = {"slip_fraction": slip_fraction(scores)} if any(s.distance_m for s in scores) else {}
    heights = [s.height_error_m for s in scores if s.height_error_m is not None and not s.fallen]
    worst = {"height_error_m": max(heights, default=None)}
    return {**row, **counts, "power_W": mean("power_W"), **worst, **slip}


def slip_fraction(scores: list[SegmentScore]) -> float | None:
    """Path slid over way made, summed over segments; None on less than 0.1 m of way."""
    way = sum(s.distance_m for s in scores)
    return sum(s.slid_m for s in scores) / way if way >= LEAST_WAY else None


def stillness(scores: list[SegmentScore]) -> dict[str, Any]:
    """RMS joint speed and lifts a second over all that stood."""
    seconds = sum(s.still_s for s in scores)
    square = sum(s.still_s * s.joint_speed_rms**2 for s in scores)
    return {
        "segments": len(scores),
        "joint_speed_rms": float(np.sqrt(square / seconds)) if seconds else None,
        "foot_lifts_per_s": sum(s.lifts for s in scores) / seconds if seconds else None,
    }
