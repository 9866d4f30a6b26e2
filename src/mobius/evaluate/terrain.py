"""How a body gets on over ground that is not a hard, flat floor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from mobius.assemble import flat_model, ground_model, variation_of
from mobius.control.bodies import body_of
from mobius.errors import UnknownName
from mobius.evaluate.commands import AXES, Segment, moving
from mobius.evaluate.episode import HOLD_S, Episode, Policy, Setup, drive
from mobius.evaluate.jobs import Progress, run_jobs
from mobius.world.ground import Ground, build_ground

SIZE = 24.0
"""Edge of the maps [m]: 20 s at 60 % of the fastest command end inside them."""
COMMANDS = 5
"""Of 4 s each."""
SHARE = 0.6
"""Of the body's range that is asked for."""
BUMPS = {"crawl": 0.05, "biped": 0.03}
"""Height of the height map [m]; that of the steps is half of it."""
SLOPE = {"crawl": 12.0, "biped": 5.0}
"""Of the faces of a pyramid; a run begins in the middle of one [deg]."""
FACE = (SIZE / 4, 0.0)
"""The middle of a face of the pyramid [m]."""
SLIPPERY = 0.35
"""Friction of the slippery floor."""
SOFT_S = 0.06
"""Time constant of the contact with the soft floor [s]; a hard floor has 0.02 s."""

MAPS: dict[str, Callable[[str, int], Ground]] = {
    "heightmap": lambda body, seed: build_ground("bumps", SIZE, seed, amplitude=BUMPS[body]),
    "slope": lambda body, seed: build_ground(
        "slope", SIZE, seed, amplitude=float(np.radians(SLOPE[body]))
    ),
    "steps": lambda body, seed: build_ground("steps", SIZE, seed, amplitude=0.5 * BUMPS[body]),
}
"""Uneven ground by kind: (body, seed) -> map."""
KINDS = (*MAPS, "slippery", "soft")
"""All kinds."""


@dataclass
class TerrainRun:
    """One episode on one kind of ground."""

    kind: str
    seed: int
    fallen: bool
    seconds: float
    """How long it lasted; 20 s without a fall."""
    distance_m: float
    """Way over the ground in steps of a stride."""
    error: list[float]
    """Mean absolute error of vx, vy [m/s], wz [rad/s] over means over a stride."""


def commands(body: str, seed: int, count: int = COMMANDS) -> list[Segment]:
    """The commands of an episode."""
    rng = np.random.default_rng([seed, 61])
    return [moving(body, rng, share=SHARE) for _ in range(count)]


def cross(kind: str, setup: Setup, segments: list[Segment], *, hold_s: float = HOLD_S) -> Episode:
    """One episode on one kind of ground, from the middle of its map or of its slope."""
    if kind in MAPS:
        ground = MAPS[kind](setup.body, setup.seed)
        if kind == "slope":
            setup = replace(setup, xy=FACE)
        return drive(setup, segments, hold_s=hold_s, model=ground_model(ground), ground=ground.at)
    model = flat_model()
    if kind == "slippery":
        slippery = replace(variation_of(setup.start()), friction=SLIPPERY)
        return drive(replace(setup, variation=slippery), segments, hold_s=hold_s, model=model)
    soles = [i for i in range(model.ngeom) if "_sole" in model.geom(i).name]
    model.geom_solref[soles, 0] = SOFT_S  # soles go before the floor: their softness counts
    return drive(setup, segments, hold_s=hold_s, model=model)


def _cross(job: tuple[str, Setup]) -> TerrainRun:
    kind, setup = job
    episode = cross(kind, setup, commands(setup.body, setup.seed))
    return TerrainRun(
        kind=kind,
        seed=setup.seed,
        fallen=episode.fallen,
        seconds=float(episode.rows["t"][-1]),
        distance_m=episode.distance(),
        error=[float(v) for v in episode.error()],
    )


@dataclass
class Terrain:
    """The outcome of ``mobius eval BODY terrain``."""

    body: str
    seed: int
    """The first seed."""
    episodes: int
    falls: int
    kinds: dict[str, dict[str, Any]]
    """Per kind: survived, episodes, distance_m (mean), mae of vx, vy [m/s], wz [rad/s]."""
    runs: list[TerrainRun] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def terrain(
    body: str,
    *,
    seeds: int,
    seed: int = 0,
    policy: Policy = None,
    randomised: bool = True,
    kinds: tuple[str, ...] = KINDS,
    workers: int = 0,
    progress: Progress | None = None,
) -> Terrain:
    """Walk 20 s over each kind of ground with a new random command every 4 s.

    Args:
        body: ``crawl`` or ``biped``.
        seeds: Episodes a kind, >= 1; the map of a kind follows from the seed.
        seed: First seed.
        policy: What drives; the shipped policy if not given.
        randomised: Draw friction, mass, servos, delay and sensors.
        kinds: Which of :data:`KINDS`.
        workers: Processes; 0 takes one a CPU.
        progress: Called with the share done after each episode.

    Raises:
        UnknownName: A kind that does not exist.
    """
    body_of(body)
    for kind in kinds:
        if kind not in KINDS:
            raise UnknownName("kind of terrain", kind, KINDS)
    jobs = [
        (kind, Setup(body, seed + k, policy, randomised)) for kind in kinds for k in range(seeds)
    ]
    runs = run_jobs(_cross, jobs, workers=workers, progress=progress)
    return Terrain(
        body=body,
        seed=seed,
        episodes=len(runs),
        falls=sum(r.fallen for r in runs),
        kinds={kind: per_kind([r for r in runs if r.kind == kind]) for kind in kinds},
        runs=runs,
    )


def per_kind(runs: list[TerrainRun]) -> dict[str, Any]:
    """What one kind came to."""
    mae = np.mean([r.error for r in runs], axis=0)
    return {
        "survived": sum(not r.fallen for r in runs),
        "episodes": len(runs),
        "distance_m": float(np.mean([r.distance_m for r in runs])),
        "mae": {axis: float(v) for axis, v in zip(AXES, mae, strict=True)},
    }
