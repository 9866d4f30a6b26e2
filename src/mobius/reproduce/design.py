"""Sec. III-C and III-D: the leg's design claims and the fatigue of its gears, ours beside
the paper's. ``python -m mobius.reproduce.design`` prints the table.
"""

from __future__ import annotations

from dataclasses import dataclass

from mobius import paper
from mobius.model.ellipsoid import design_claims
from mobius.model.fatigue import ARM_GEAR, LEG_GEAR, cycles_to_failure


@dataclass(frozen=True)
class Row:
    """One figure."""

    what: str
    ours: float
    paper: float
    note: str = ""


def rows() -> list[Row]:
    """Computed now, from geometry and Eq. (1)."""
    claims, wide = design_claims(), design_claims(w=0.0335)
    fatigue = paper.GEAR_FATIGUE
    torque = fatigue.peak_torque
    return [
        Row("ellipsoid volume", claims.volume_change, paper.LEG_DESIGN.ellipsoid_volume),
        Row("condition number", claims.condition_change, paper.LEG_DESIGN.condition_number),
        Row(
            "condition number, servos 33.5 mm apart",
            wide.condition_change,
            paper.LEG_DESIGN.condition_number,
            "the leg's own servo width",
        ),
        Row("arm gear stress [MPa]", 1e-6 * float(ARM_GEAR.stress(torque)), 986.0, "calibrates"),
        Row("leg gear stress [MPa]", 1e-6 * float(LEG_GEAR.stress(torque)), 496.0, "calibrates"),
        Row("arm gear cycles", float(cycles_to_failure(986e6)), fatigue.arm_life, "S-N point"),
        Row("leg gear cycles", float(cycles_to_failure(496e6)), fatigue.leg_life, "S-N point"),
    ]


def main() -> None:
    """Print the table."""
    print(f"{'':42s}{'ours':>12s}{'paper':>12s}")
    for row in rows():
        print(f"{row.what:42s}{row.ours:12.4g}{row.paper:12.4g}  {row.note}")


if __name__ == "__main__":
    main()
