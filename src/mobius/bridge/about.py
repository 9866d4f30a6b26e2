"""What a log says of the run as a whole: map, seed, robot, versions and the scene itself.

It stands at the head of the file, before the first message: a MCAP metadata record ``mobius``
of strings, and an attachment ``scene.xml.gz`` with everything that physics was built from,
so that a run can be looked at when the map's own file has gone.
"""

from __future__ import annotations

import gzip
import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from mobius.errors import InvalidInput

__all__ = ["About"]

RECORD = "mobius"
"""Name of the metadata record."""
SCENE = "scene.xml.gz"
"""Name of the attachment."""
FORMAT = "1"
"""Raised when an older reader would understand a record wrongly."""


@dataclass(frozen=True, eq=False)
class About:
    """What was recorded; what is not known stays empty."""

    map: str = ""
    """Name of the map that was driven."""
    seed: int | None = None
    """Of robot, floor and sensors."""
    variation: Mapping[str, Any] = field(default_factory=dict)
    """How the robot differed from the drawing: the fields of
    :class:`mobius.robot.variation.Variation` by name."""
    versions: Mapping[str, str] = field(default_factory=dict)
    """Of mobius, mujoco and what else a result depends on."""
    scene: str = ""
    """MJCF of the whole scene, the robot included."""

    def as_record(self) -> dict[str, str]:
        """All but the scene, as strings."""
        return {
            "format": FORMAT,
            "map": self.map,
            "seed": "" if self.seed is None else str(self.seed),
            "variation": json.dumps(dict(self.variation)),
            "versions": json.dumps(dict(self.versions)),
        }

    def packed_scene(self) -> bytes:
        """The scene, compressed; the same scene gives the same bytes."""
        return gzip.compress(self.scene.encode(), mtime=0)

    @classmethod
    def from_record(cls, record: Mapping[str, str], packed_scene: bytes = b"") -> About:
        """Back from what :meth:`as_record` and :meth:`packed_scene` gave.

        Raises:
            InvalidInput: A later format, or a record that cannot be understood.
        """
        told = record.get("format", FORMAT)
        if told != FORMAT:
            raise InvalidInput(
                f"the log's record '{RECORD}' has format {told}, expected {FORMAT}; type:"
                " pip install --upgrade mobius"
            )
        try:
            return cls(
                map=record.get("map", ""),
                seed=int(record["seed"]) if record.get("seed") else None,
                variation=dict(json.loads(record.get("variation") or "{}")),
                versions=dict(json.loads(record.get("versions") or "{}")),
                scene=gzip.decompress(packed_scene).decode() if packed_scene else "",
            )
        except (ValueError, TypeError, OSError, EOFError, zlib.error) as error:
            raise InvalidInput(
                f"the log's record '{RECORD}' cannot be understood ({error})"
            ) from None
