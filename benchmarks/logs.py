"""What recording costs: time in the loop, size on the disk, time to open.

    python benchmarks/logs.py [--seconds 60]

A crawl on the demo map is recorded live, truth beside it. Times are processor time, so that a
busy machine does not count; they go to benchmarks/results/logs.json.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from mobius.assemble import Start, build_sim_stack
from mobius.bridge.about import About
from mobius.bridge.read_run import open_run
from mobius.bridge.record import McapRecorder
from mobius.files import write_json_atomic
from mobius.mission import open_world
from mobius.model.robot import load_spec
from mobius.types import Mode, ModeCommand
from mobius.world.scene import build_scene

RESULTS = Path(__file__).parent / "results" / "logs.json"


def record(path: Path, seconds: float) -> list[float]:
    """Record a crawl in circles; seconds that each sample took the recorder."""
    world = open_world("demo")
    spec = build_scene(world, load_spec("full"))
    model = spec.compile()
    x, y = world.grid.start
    stack, robot = build_sim_stack(model, Start(xy=(float(x), float(y))))
    took = []
    with McapRecorder(path=path, about=About(map="demo", scene=spec.to_xml())) as recorder:
        recorder.once(grid=world.grid)
        for _ in range(round(600 * seconds)):
            sample = stack.turn(
                lambda b: ModeCommand(Mode.CRAWL, np.array([0.1, 0.0, 0.3]), b.stamp)
            )
            if sample is not None:
                truth = robot.truth()
                began = time.thread_time()
                recorder.see(sample, truth)
                took.append(time.thread_time() - began)
    return took


def measure(seconds: float) -> dict[str, Any]:
    """All figures."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        took = 1e3 * np.array(record(path, seconds))
        size = path.stat().st_size
        began = time.thread_time()
        run = open_run(path)
        opened = time.thread_time() - began
        model = run.model()
        began = time.thread_time()
        run.qpos(model)
        posed = time.thread_time() - began
    return {
        "seconds": seconds,
        "samples": len(took),
        "sample_ms": {f"p{p:g}": float(np.percentile(took, p)) for p in (50, 95, 99, 99.9, 100)},
        "share_of_real_time": float(took.sum() / 1e3 / seconds),
        "kB_per_s": size / 1e3 / seconds,
        "open_s_per_minute": opened * 60 / seconds,
        "qpos_s_per_minute": posed * 60 / seconds,
    }


def main() -> None:
    """Measure, print, keep."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    result = measure(parser.parse_args().seconds)
    print(json.dumps(result, indent=2))
    write_json_atomic(RESULTS, result)


if __name__ == "__main__":
    main()
