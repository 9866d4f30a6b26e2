"""What there is to see: each motion by itself, and the demo reel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mobius.assemble import BEGIN_IN, Start, build_sim_stack, flat_model
from mobius.errors import UnknownName
from mobius.modes import load_motion, motion_names
from mobius.modes.motions import Motion
from mobius.reel.acts import Act, Script
from mobius.reel.film import Footage, film
from mobius.types import Mode

LIMIT_S = 180.0
"""No show lasts longer [s]."""
FEW = 3
"""Push-ups in a show; the motion itself has twenty."""


@dataclass(frozen=True)
class Show:
    """One run: where it starts, what the robot can, what is asked."""

    name: str
    what: str
    """In a few words."""
    keyframe: str
    acts: tuple[Act, ...]
    modes: tuple[str, ...] = ("crawl",)
    needs: tuple[str, ...] = ()
    """Motions it cannot do without."""


_STAND, _CRAWL = Act(Mode.BIPED, 1.0), Act(Mode.CRAWL, 1.0)
_BOTH = ("crawl", "biped")
REEL = Show(
    "reel",
    "all modes in one run",
    "crawl",
    (
        Act(Mode.CRAWL, 3.0, (0.45, 0.0, 0.0)),
        Act(Mode.BIPED, 4.0, (0.2, 0.0, 0.0)),
        Act(Mode.BIPED, 3.0, (0.0, 0.0, 0.45)),
        Act(Mode.CRAWL, 1.0),
        Act(Mode.PUSH_UPS),
        Act(Mode.ROLL),
        Act(Mode.ROLL),
        Act(Mode.BIPED, 1.0),
        Act(Mode.BIPED, 2.0, shove=(-1.5, 0.0)),
        Act(Mode.BIPED, 2.5, (0.0, 0.0, -0.45)),
    ),
    ("crawl", "biped", "roll", "push_ups"),
    ("prone_to_crawl", "supine_to_crawl", "head_recovery"),
)
"""The demo reel."""
SHOWS: dict[str, Show] = {
    s.name: s
    for s in (
        Show("prone_to_crawl", "Fig. 13 A: up from the belly", "prone", (_CRAWL,)),
        Show("stand_to_crawl", "Fig. 13 B: lie down", "stand", (_STAND, _CRAWL), _BOTH),
        Show("crawl_to_stand", "Fig. 13 D: stand up", "crawl", (_CRAWL, _STAND), _BOTH),
        Show("supine_to_crawl", "up from the back over the rails", "supine", (_CRAWL,)),
        Show("supine_recovery", "from the back to the stand", "supine", (_STAND,), ("biped",)),
        Show("head_recovery", "up from the head", "on_head", (_CRAWL,)),
        Show(
            "roll",
            "Fig. 13 C: a full turn backward",
            "crawl",
            (_CRAWL, Act(Mode.ROLL), _CRAWL),
            ("crawl", "roll"),
        ),
        Show(
            "push_ups",
            f"{FEW} of them",
            "crawl",
            (_CRAWL, Act(Mode.PUSH_UPS), _CRAWL),
            ("crawl", "push_ups"),
        ),
    )
}
"""One for each motion, by its name."""


def shortened(motion: Motion, times: int) -> Motion:
    """A motion that repeats its stages, with only ``times`` of the repetitions."""
    first = motion.stages[0].q
    again = [k for k, s in enumerate(motion.stages) if k and np.array_equal(s.q, first)]
    period = again[0] if again else len(motion.stages)
    return replace(motion, stages=motion.stages[: period * times])


def show_of(name: str) -> Show:
    """The show of a motion, or the reel. Raises :class:`UnknownName`."""
    known = {REEL.name: REEL, **SHOWS}
    if name not in known:
        raise UnknownName("motion to show", name, known)
    return known[name]


def play(
    show: Show,
    *,
    seed: int = 0,
    randomised: bool = True,
    motions: Mapping[str, Motion] | None = None,
) -> Footage:
    """Run a show in physics with the whole stack.

    Args:
        show: What.
        seed: Of friction, mass, servo strength, delay and sensor noise.
        randomised: Draw these from the seed; else the robot is as drawn.
        motions: By name; the shipped ones if not given.

    Raises:
        UnknownName: A motion that it needs is not there.
    """
    known = dict(motions or {name: load_motion(name) for name in motion_names()})
    own = (show.name,) if show.name in SHOWS else ()
    for name in (*own, *show.needs):
        if name not in known:
            raise UnknownName("motion", name, known)
    if "push_ups" in known:
        known["push_ups"] = shortened(known["push_ups"], FEW)
    body = "biped" if show.acts[-1].mode is Mode.BIPED and "crawl" not in show.modes else "crawl"
    start = Start(body=body, keyframe=show.keyframe, seed=seed, randomised=randomised)
    stack, robot = build_sim_stack(flat_model(), start, modes=show.modes, motions=known)
    first = BEGIN_IN.get(show.keyframe, Mode.RECOVER)
    return film(stack, robot, Script(show.acts, first), limit_s=LIMIT_S)
