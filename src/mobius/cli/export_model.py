"""``mobius model``: the robot as a file for other tools."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from mobius.errors import InvalidInput


@dataclass
class Model:
    """Write the robot as URDF (rviz, Foxglove, Pinocchio) or MJCF (MuJoCo)."""

    to: Literal["urdf", "mjcf"] = "urdf"
    """urdf: a serial tree whose passive joints need values, see docs/ros2.md; mjcf: with the
    loops closed, as it is simulated here."""
    out: Path | None = None
    """File to write; mobius.urdf or mobius.xml if left out."""

    def __call__(self) -> int:
        """Write it and say where it is."""
        from mobius.files import write_text_atomic

        suffix = ".urdf" if self.to == "urdf" else ".xml"
        out = self.out or Path(f"mobius{suffix}")
        if out.suffix != suffix:
            raise InvalidInput(f"--out: expected a file that ends in {suffix}, got {out}")
        if out.is_dir():
            raise InvalidInput(f"--out: {out} is a folder; name a file in it")
        try:
            write_text_atomic(out, _text(self.to))
        except OSError as error:
            raise InvalidInput(f"--out: {out} cannot be written ({error.strerror})") from None
        print(out)
        return 0


def _text(kind: str) -> str:
    if kind == "urdf":
        from mobius.model.urdf import build_urdf

        return build_urdf()
    from mobius.model.build import ROBOT_XML

    return ROBOT_XML.read_text()
