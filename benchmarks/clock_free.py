"""A walker from the paper's own observation: no gait clock (Sec. IV-A2).

    python benchmarks/clock_free.py [biped|crawl] [--rounds 250] [--seeds 20] [--out FOLDER]

Teaches a student that sees 416 (608) numbers the actions of the shipped policy, which has a
clock (``mobius.train.distill``), writes it as ONNX and evaluates it in the whole stack.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from mobius.control.policy import load_policy, shipped_policy
from mobius.evaluate import push, tracking
from mobius.train.distill import distill
from mobius.train.env import LocomotionEnv
from mobius.train.export import write_onnx
from mobius.train.presets import preset_of


def main() -> None:
    """Teach, write, evaluate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("body", nargs="?", default="biped", choices=("biped", "crawl"))
    parser.add_argument("--rounds", type=int, default=250)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("runs/clock-free"))
    args = parser.parse_args()
    teacher = load_policy(shipped_policy(args.body))
    preset = preset_of(args.body, "fast")
    env = LocomotionEnv(preset.env, preset.num_envs, seed=args.seed, nthread=args.threads)
    env.curriculum.command = 1.0
    env.curriculum.kick = 0.4
    begin = time.perf_counter()

    def show(f: dict[str, float]) -> None:
        if f["round"] % 10 == 0:
            print(json.dumps({k: round(v, 4) for k, v in f.items()}), flush=True)

    student = distill(env, teacher, rounds=args.rounds, seed=args.seed, progress=show)
    wall = time.perf_counter() - begin
    args.out.mkdir(parents=True, exist_ok=True)
    path = args.out / f"{args.body}_clock_free.onnx"
    metadata = {
        **teacher.metadata,
        "frame": "paper",
        "history": 16,
        "clock": False,
        "preset": "clock-free",
        "seed": args.seed,
        "steps": args.rounds * 24 * preset.num_envs,
        "wall_s": round(wall, 1),
        "observation": None,
        "config": None,
        "curve": [],
    }
    write_onnx(student.eval(), student.mean.numel(), metadata, path)
    print(f"{path}: {wall:.0f} s", flush=True)
    result = tracking(args.body, seeds=args.seeds, policy=path).as_json()
    result.pop("runs")
    print(json.dumps(result))
    pushes = push(args.body, seeds=args.seeds, policy=path).as_json()
    print(json.dumps({k: pushes[k] for k in ("magnitudes_mps", "survival")}))


if __name__ == "__main__":
    main()
