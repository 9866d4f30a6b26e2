"""Trials of the motions over many seeds, kept in benchmarks/results/motions.json, as a table.

    python benchmarks/motions.py [NAME ...] [--seeds 100]     # run, keep, print
    python benchmarks/motions.py --keep a.json b.json         # keep what mobius eval motions --json
                                                              # has printed, and print all

What is not run this time stays as it was. The table of all that is kept goes to docs/motions.md,
between its two marks.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from mobius.evaluate.trials import TRIALS, motion_trials
from mobius.files import write_json_atomic, write_text_atomic

HERE = Path(__file__).parent
RESULTS = HERE / "results" / "motions.json"
DOCS = HERE.parent / "docs" / "motions.md"
BEGIN, END = "<!-- trials table -->", "<!-- end of it -->"


def table(kept: dict[str, dict[str, Any]]) -> str:
    """A Markdown row for every motion."""
    lines = [
        "| motion | successes | median | largest torque, root mean square | gear cycles | more |",
        "|---|---|---|---|---|---|",
    ]
    for name in TRIALS:
        if name not in kept:
            continue
        f = kept[name]
        more = ""
        if f.get("speed_mps") is not None:
            more = (
                f"{f['speed_mps']:.2f} m/s rolling, {f['average_mps']:.2f} with all stances,"
                f" heading {f['heading_error_deg']:.1f} deg off"
            )
        median = "-" if f["median_s"] is None else f"{f['median_s']:.1f} s"
        lines.append(
            f"| `{name}` | {f['successes']} of {f['trials']} | {median}"
            f" | {f['peak_torque_Nm']:.1f}, {f['rms_torque_Nm']:.1f} N m"
            f" | {life(f['gear_life_cycles'])} | {more} |"
        )
    return "\n".join(lines)


def life(cycles: Any) -> str:
    """Cycles of the gear that lives shortest if each had the largest torque of all, Eq. (1)."""
    least = min(cycles.values()) if isinstance(cycles, dict) else cycles
    return "-" if least is None else f"{float(least):.2g}"


def main() -> None:
    """Run or take in, keep, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[*TRIALS, []], help="all if none")
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--keep", nargs="+", type=Path, default=[])
    args = parser.parse_args()
    kept: dict[str, dict[str, Any]] = {}
    if RESULTS.exists():
        kept = json.loads(RESULTS.read_text())["motions"]
    for path in args.keep:
        kept.update(json.loads(path.read_text())["motions"])
    if not args.keep:
        for name in args.names or TRIALS:
            print(f"{name}, {args.seeds} seeds", flush=True)
            kept.update(motion_trials([name], seeds=args.seeds).as_json()["motions"])
    write_json_atomic(RESULTS, {"motions": kept})
    text, rows = DOCS.read_text(), table(kept)
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1] if END in rest else rest
    write_text_atomic(DOCS, f"{before}{BEGIN}\n\n{rows}\n\n{END}{after}")
    print(rows)


if __name__ == "__main__":
    main()
