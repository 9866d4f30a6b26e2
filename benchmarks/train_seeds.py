"""Does a preset learn to the bar from nothing, whatever the seed, and how long does it take?

    python benchmarks/train_seeds.py crawl|biped [--seeds 3] [--first 0] [--episodes 20]
                                     [--threads 0] [--out runs/seeds]

Trains the ``fast`` preset once a seed into OUT/BODY-SEED (a run that is there already is gone on
with, or only evaluated), exports it and lets it track commands in the whole stack. Figures go
to benchmarks/results/BODY_seeds.json, in which seeds that are not run this time stay. ``wall_s``
is the sum over iterations of the training loop, on as many cores as ``threads`` says (0: all)
beside whatever else the machine does.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from mobius.evaluate import tracking
from mobius.files import write_json_atomic
from mobius.train.export import export
from mobius.train.learn import CHECKPOINT, load_checkpoint, train
from mobius.train.presets import preset_of

BARS = {"crawl": (0.04, 0.08, 0.0), "biped": (0.025, 0.06, 0.01)}
"""Mean absolute error of vx and vy [m/s], of wz [rad/s], falls an episode; at most."""
RESULTS = Path(__file__).parent / "results"


def learn(body: str, seed: int, run: Path, threads: int) -> dict[str, Any]:
    """Train to the end; what it took."""
    preset = preset_of(body, "fast")
    if not (run / CHECKPOINT).exists() or load_checkpoint(run)["steps"] < preset.steps:
        train(
            preset,
            run,
            seed=seed,
            threads=threads,
            learner_threads=threads,
            resume=(run / CHECKPOINT).exists(),
        )
    export(preset, "fast", run, run / "policy.onnx")
    end = load_checkpoint(run)
    return {"seed": seed, "steps": end["steps"], "wall_s": round(end["elapsed"], 1)}


def judge(body: str, policy: Path, episodes: int) -> dict[str, Any]:
    """Tracking over the whole command range."""
    result = tracking(body, seeds=episodes, policy=policy).as_json()
    linear, yaw, falls = BARS[body]
    mae = result["mae"]
    reached = max(mae["vx"], mae["vy"]) <= linear and mae["wz"] <= yaw
    return {
        "episodes": result["episodes"],
        "falls": result["falls"],
        "mae": mae,
        "reached": bool(reached and result["falls"] <= falls * result["episodes"]),
    }


def main() -> None:
    """Every seed, one after another."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("body", choices=tuple(BARS))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("runs/seeds"))
    args = parser.parse_args()
    file = RESULTS / f"{args.body}_seeds.json"
    kept = json.loads(file.read_text())["seeds"] if file.exists() else []
    rows = {row["seed"]: row for row in kept}
    for seed in range(args.first, args.first + args.seeds):
        run = args.out / f"{args.body}-{seed}"
        row = learn(args.body, seed, run, args.threads)
        row |= judge(args.body, run / "policy.onnx", args.episodes)
        print(json.dumps(row), flush=True)
        rows[seed] = row
        write_json_atomic(file, {"preset": "fast", "seeds": [rows[k] for k in sorted(rows)]})


if __name__ == "__main__":
    main()
