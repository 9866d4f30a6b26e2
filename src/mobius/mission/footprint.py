"""How much room the crawling robot takes, which depends on the stance of its policy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mobius.headless import import_mujoco
from mobius.types import Mode


@dataclass(frozen=True)
class Footprint:
    """What stays clear of obstacles around the trunk."""

    radius: float
    """Disc that holds the crawling stance in every heading [m]."""
    lane: float
    """Least distance to obstacles where it only goes straight [m]: half the width that it takes
    crawling, hands in their swing included, and 2 cm."""
    margin: float = 0.04
    """How far the robot's centre may stray from its planned line [m]."""


WIDE = Footprint(radius=0.47, lane=0.43)
"""Of the shipped policy for flat floors; a test holds its stance and its crawl to it."""
NARROW = Footprint(radius=0.41, lane=0.34)
"""Of policies that stand in keyframe ``crawl``, as that for rough ground does; a test holds the
stance and that one's crawl to it."""


def footprint_of(policy: Path | str | None) -> Footprint:
    """What a mission on ``policy`` keeps clear (:func:`mobius.control.peers.controller_of`).

    None, which leaves the choice to the map's ground, is :data:`WIDE`.

    Raises:
        PolicyError: The file lacks, is no policy, or drives another body.
        UnknownName: Neither a policy's name nor that of an ONNX file.
    """
    if policy is None:
        return WIDE
    import_mujoco()
    from mobius.control.peers import controller_of  # imports mujoco, which would look for OpenGL

    apart = getattr(controller_of(policy, Mode.CRAWL.value), "apart", False)
    return WIDE if apart else NARROW
