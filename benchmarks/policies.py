"""Evaluate the shipped policies and write their model cards.

    python benchmarks/policies.py [NAME ...] [--seeds 100] [--what tracking push terrain ...]

NAME is a file of src/mobius/control/policies without its ending; all of them if none is given.
Figures go to benchmarks/results/NAME.json (what is not evaluated this time stays as it was),
and from there and from the policy's own metadata to src/mobius/control/policies/NAME.md.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mobius.control.policy import load_policy
from mobius.evaluate import push, robustness, terrain, tracking
from mobius.files import write_json_atomic, write_text_atomic

HERE = Path(__file__).parent
POLICIES = HERE.parent / "src" / "mobius" / "control" / "policies"
RESULTS = HERE / "results"
PAPER_SPEED = {"crawl": 0.4 / 0.7, "biped": 0.1 / 0.25}
"""The paper's forward speed as a share of ours."""


def evaluate(name: str, what: list[str], seeds: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """The chosen evaluations of one policy; plain values without the single runs."""
    path = POLICIES / f"{name}.onnx"
    body = load_policy(path).body.mode.value
    jobs = {
        "tracking": lambda: tracking(body, seeds=seeds, policy=path),
        "paper_speed": lambda: tracking(body, seeds=seeds, policy=path, speed=PAPER_SPEED[body]),
        "push": lambda: push(body, seeds=seeds, policy=path),
        "terrain": lambda: terrain(body, seeds=seeds, policy=path, kinds=("heightmap", "slope")),
        "robustness": lambda: robustness(body, seeds=max(seeds // 5, 1), policy=path),
    }
    for key in what:
        print(f"{name}: {key}, {seeds} seeds", flush=True)
        result = jobs[key]().as_json()
        result.pop("runs", None)
        print(json.dumps(result), flush=True)
        yield key, result


def build_card(name: str, meta: dict[str, Any], figures: dict[str, Any]) -> str:
    """The model card as Markdown."""
    lines = [
        f"# {name}.onnx",
        "",
        f"Body `{meta['body']}`. Sees {meta['frame']} frames x {meta['history']}"
        + (" and a gait clock" if meta["clock"] else "")
        + f"; moves {len(meta['joints'])} joints at 60 Hz by Eq. (2).",
        "",
        *_training_lines(meta),
        "## Figures",
        "",
        "In the whole stack: full collision geometry, physics at 1/600 s, friction, mass, servos,",
        "delay and sensors drawn from the seed, the estimator's belief, judged on the truth.",
        "`python benchmarks/policies.py` prints them.",
        "",
    ]
    for key in ("tracking", "paper_speed"):
        if key in figures:
            lines += _tracking_lines(key, figures[key])
    if "push" in figures:
        p = figures["push"]
        head = " | ".join(f"{m:.1f}" for m in p["magnitudes_mps"])
        lines += [f"| shoved [m/s] | {head} |", "|---" * (len(p["magnitudes_mps"]) + 1) + "|"]
        for state, survival in p["survival"].items():
            lines.append(f"| {state} | " + " | ".join(f"{s:.0%}" for s in survival) + " |")
        lines.append("")
    if "terrain" in figures:
        lines += ["| ground | no fall in 20 s | way [m] |", "|---|---|---|"]
        for kind, t in figures["terrain"]["kinds"].items():
            lines.append(f"| {kind} | {t['survived']} of {t['episodes']} | {t['distance_m']:.1f} |")
        lines.append("")
    if "robustness" in figures:
        lines += _robustness_lines(figures["robustness"])
    lines += [
        "## Limits",
        "",
        "Simulation only. Not trained on stairs, on ground that moves, or with a load in the",
        "grippers. The gait clock is ours, not the paper's." if meta["clock"] else "grippers.",
        "",
    ]
    return "\n".join(lines)


def _training_lines(meta: dict[str, Any]) -> list[str]:
    """What it was trained with, and where training ended."""
    ground = meta["config"]["env"].get("terrain")
    lines = [
        f"Trained with preset `{meta['preset']}`, seed {meta['seed']},"
        f" {meta['steps'] / 1e6:.1f} M environment steps in {meta['wall_s'] / 60:.0f} min on"
        f" {'uneven ground' if ground else 'a flat floor'}; exported at commit"
        f" `{meta.get('git', '?')}`.",
    ]
    if meta.get("warm_start"):
        lines[0] += f" Went on from a run of {meta['warm_start']['steps'] / 1e6:.1f} M steps."
    if meta.get("curve"):
        head = meta["curve_columns"]
        rows = [
            meta["curve"][i] for i in sorted({0, len(meta["curve"]) // 2, -1 % len(meta["curve"])})
        ]
        lines += ["", "| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
        lines += ["| " + " | ".join(f"{v:g}" for v in row) + " |" for row in rows]
    return [*lines, ""]


def _robustness_lines(r: dict[str, Any]) -> list[str]:
    """Survival along every swept quantity."""
    lines = ["| changed alone | value: share without a fall in 10 s |", "|---|---|"]
    for sweep in r["sweeps"].values():
        cells = zip(sweep["values"], sweep["survival"], strict=True)
        lines.append(
            f"| {sweep['what']} | " + ", ".join(f"{v:g}: {s:.0%}" for v, s in cells) + " |"
        )
    return [*lines, ""]


def _tracking_lines(key: str, t: dict[str, Any]) -> list[str]:
    title = "full range" if key == "tracking" else "the paper's speed"
    m = t["mae"]
    return [
        f"Tracking, {title}, {t['episodes']} x 20 s: mean abs. error {m['vx']:.3f},"
        f" {m['vy']:.3f} m/s, {m['wz']:.3f} rad/s; {t['falls']} falls; power"
        f" {t['power_W']:.0f} W; saturated {t['saturation']:.1%}; slip"
        f" {t['slip_fraction']:.1%}; chatter {t['chatter_fraction']:.1%}; fastest joint"
        f" {t['max_dq_rpm']:.0f} rpm; trunk within {t['height_error_m']:.3f} m of the stance"
        + (f" ({t['height_error_p95_m']:.3f} in 95 %)." if "height_error_p95_m" in t else "."),
        "",
        "| command | target | mean | error | power [W] | falls |",
        "|---|---|---|---|---|---|",
        *(
            f"| {name} | {_row(c['target'])} | {_row(c['mean'])} | {_row(c['mae'])} |"
            f" {_value(c['power_W'])} | {c['falls']} |"
            for name, c in t["commands"].items()
        ),
        "",
    ]


def _row(values: list[float] | None) -> str:
    return "-" if values is None else ", ".join(f"{v:.3f}" for v in values)


def _value(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"


def main() -> None:
    """Evaluate and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument(
        "--what", nargs="*", default=["tracking", "paper_speed", "push", "terrain", "robustness"]
    )
    args = parser.parse_args()
    RESULTS.mkdir(exist_ok=True)
    for name in args.names or sorted(p.stem for p in POLICIES.glob("*.onnx")):
        file = RESULTS / f"{name}.json"
        figures = json.loads(file.read_text()) if file.exists() else {}
        meta = load_policy(POLICIES / f"{name}.onnx").metadata
        for key, result in evaluate(name, args.what, args.seeds):
            figures[key] = result
            write_json_atomic(file, figures)
        write_text_atomic(POLICIES / f"{name}.md", build_card(name, meta, figures))


if __name__ == "__main__":
    main()
