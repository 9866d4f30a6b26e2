"""Training: env-steps a second against raw physics and against a gymnasium vector env.

    python benchmarks/bench_train.py [--body crawl] [--preset fast] [--rounds 6] [--json]

All three take turns in one run on the same cores, so that whatever else the machine does hits
all of them; ratios are medians over the rounds. An env-step is one robot for 1/60 s. Processor
time an env-step is given beside wall time: it says more where other jobs take the cores.

- train: rollout (physics, host, inference) and update, as ``mobius train`` does it.
- raw: ``mujoco.batch`` alone: same model, robots, states, randomised fields, substeps and sensor
  stage, with random targets around the policy's.
- gym: ``gymnasium.vector.AsyncVectorEnv`` of the single-robot ``mobius/...-v0``, a process each,
  random actions, no learner. The number of processes is the best of those given. The environment
  is the vectorised one with n = 1, so most of its time is numpy's, not MuJoCo's.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_WAIT_POLICY", "passive")

import gymnasium
import numpy as np

# The processes of the vector env import this file again and need none of the learner, so
# what brings torch is imported where it is used.
from mobius.train.presets import Preset, preset_of

PARTS = ("physics", "resets", "host", "inference", "update", "other")
BARS = {"train/raw": 0.45, "train/gym": 3.0}


class Clock:
    """Adds up wall time by name; names do not overlap."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self._inside: list[float] = []

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time what stands inside the ``with``."""
        began = time.perf_counter()
        self._inside.append(0.0)
        yield
        took = time.perf_counter() - began
        self.seconds[name] += took - self._inside.pop()
        if self._inside:
            self._inside[-1] += took

    def wrap(self, owner: Any, method: str, name: str) -> None:
        """Count every call of a bound method as ``name``."""
        inner = getattr(owner, method)

        def timed(*args: Any, **kwargs: Any) -> Any:
            with self(name):
                return inner(*args, **kwargs)

        setattr(owner, method, timed)


class Training:
    """The training loop, timed part by part."""

    def __init__(self, preset: Preset, threads: int, folder: Path) -> None:
        from mobius.train.guard import Guard
        from mobius.train.parts import PARTS
        from mobius.train.ppo import build_learner
        from mobius.train.snapshot import seed_everything
        from mobius.train.vec import RslVecEnv
        from mobius.train.watch import WatchedEnv

        seed_everything(0)
        self.preset = preset
        self.env = WatchedEnv(preset.env, preset.num_envs, seed=0, nthread=threads)
        self.vec = RslVecEnv(self.env)
        self.learner_threads = min(threads, PARTS)
        self.learner = build_learner(preset, self.vec, self.learner_threads)
        self.guard = Guard(preset, self.vec, self.learner, folder)
        self.env.steps[:] = self.env.rng.integers(0, self.env.max_steps, self.env.n)
        self.learner.train_mode()
        self.clock = Clock()
        for owner, method, name in (
            (self.env.sim, "step", "physics"),
            (self.env.sim, "place", "resets"),
            (self.env.sim, "constants_changed", "resets"),
            (self.vec, "step", "host"),
            (self.learner, "act", "inference"),
            (self.learner, "process_env_step", "inference"),
            (self.learner, "compute_returns", "inference"),
            (self.learner, "update", "update"),
        ):
            self.clock.wrap(owner, method, name)
        self.done = 0

    def block(self) -> int:
        """One iteration; env-steps done."""
        from mobius.train.learn import anneal, iterate

        batch = self.preset.horizon * self.preset.num_envs
        with self.clock("other"):
            anneal(self.preset, self.learner, self.done)
            iterate(self.vec, self.learner, self.preset.horizon, self.guard, self.done)
        self.done += batch
        return batch


class Raw:
    """The same physics with nothing around it."""

    def __init__(self, training: Training, threads: int) -> None:
        from mobius.train.batch import CpuBatch

        env = training.env
        self.source, self.substeps = env, env.cfg.substeps
        self.sim = CpuBatch(env.sim.model, env.body, env.n, threads)
        self.rng = np.random.default_rng(1)

    def prepare(self) -> None:
        """Robots where those in training are."""
        self.sim.load_state(self.source.sim.state())
        self.targets = np.array(self.sim.ctrl)

    def block(self, steps: int) -> int:
        """``steps`` policy steps; env-steps done."""
        shape = self.targets.shape
        for _ in range(steps):
            self.sim.ctrl[:] = self.targets + self.rng.normal(0, 0.1, shape)
            self.sim.step(self.substeps)
        return steps * self.sim.n


class Gym:
    """Single-robot environments, a process each."""

    def __init__(self, body: str, preset: str, processes: int) -> None:
        name = f"mobius.train.gym:mobius/{body.capitalize()}-v0"

        def make() -> gymnasium.Env[Any, Any]:
            return gymnasium.make(name, preset=preset, disable_env_checker=True)

        self.n = processes
        self.envs = gymnasium.vector.AsyncVectorEnv([make] * processes, context="spawn")
        self.envs.reset(seed=0)
        self.envs.action_space.seed(0)

    def block(self, steps: int) -> int:
        """``steps`` policy steps; env-steps done."""
        for _ in range(steps):
            self.envs.step(self.envs.action_space.sample() * 0.25)
        return steps * self.n

    def cpu_s(self) -> float:
        """Processor time of all processes and of this one."""
        return time.process_time() + sum(_cpu_s(p.pid) for p in self.envs.processes)

    def memory_mb(self) -> float:
        """Of all processes together, shared pages counted once."""
        return sum(_pss_mb(p.pid) for p in self.envs.processes)


def _cpu_s(pid: int | None) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _pss_mb(pid: int | None) -> float:
    for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
        if line.startswith("Pss:"):
            return int(line.split()[1]) / 1024
    return float("nan")


def _rate(block: Callable[[], int]) -> float:
    began = time.perf_counter()
    return block() / (time.perf_counter() - began)


def _turn(block: Callable[[], int], cpu: Callable[[], float]) -> tuple[float, float]:
    """Env-steps a second, and microseconds of processor time an env-step."""
    before, began = cpu(), time.perf_counter()
    steps = block()
    took, used = time.perf_counter() - began, cpu() - before
    return steps / took, 1e6 * used / steps


def best_gym(body: str, preset: str, counts: list[int]) -> Gym:
    """The vector env with the number of processes that is quickest here."""
    best: tuple[float, Gym] | None = None
    for count in counts:
        gym = Gym(body, preset, count)
        gym.block(10)
        rate = _rate(partial(gym.block, max(20, 1000 // count)))
        if best is None or rate > best[0]:
            if best is not None:
                best[1].envs.close()
            best = rate, gym
        else:
            gym.envs.close()
    assert best is not None
    return best[1]


def measure(args: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """All rounds; rates in env-steps/s, shares of the training loop, memory in MB."""
    import mujoco
    import torch

    preset = preset_of(args.body, args.preset)
    preset = replace(preset, num_envs=args.robots or preset.num_envs)
    threads = args.threads or len(os.sched_getaffinity(0))
    training = Training(preset, threads, folder)
    training.block()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    raw = Raw(training, threads)
    gym = best_gym(args.body, args.preset, args.processes)
    raw.prepare()
    raw.block(4)
    training.clock.seconds.clear()
    turns: dict[str, list[tuple[float, float]]] = {"train": [], "raw": [], "gym": []}
    for _ in range(args.rounds):
        turns["train"].append(_turn(training.block, time.process_time))
        raw.prepare()
        turns["raw"].append(_turn(partial(raw.block, preset.horizon), time.process_time))
        turns["gym"].append(_turn(partial(gym.block, max(20, 1500 // gym.n)), gym.cpu_s))
    gym_memory = gym.memory_mb()
    gym.envs.close()
    rates, cpu = ({k: np.array(v)[:, i] for k, v in turns.items()} for i in (0, 1))
    total = sum(training.clock.seconds.values())
    return {
        "body": args.body,
        "preset": args.preset,
        "robots": preset.num_envs,
        "threads": threads,
        "learner_threads": training.learner_threads,
        "rounds": args.rounds,
        "steps_per_s": {k: round(float(np.median(v)), 1) for k, v in rates.items()},
        "ratios": {
            f"train/{k}": round(float(np.median(rates["train"] / rates[k])), 3)
            for k in ("raw", "gym")
        },
        "cpu_us_per_step": {k: round(float(np.median(v)), 1) for k, v in cpu.items()},
        "cpu_ratios": {
            f"train/{k}": round(float(np.median(cpu[k] / cpu["train"])), 3) for k in ("raw", "gym")
        },
        "bars": BARS,
        "shares": {k: round(training.clock.seconds[k] / total, 4) for k in PARTS},
        "ms_per_iteration": {
            k: round(1e3 * training.clock.seconds[k] / args.rounds, 1) for k in PARTS
        },
        "memory_mb": {"train": round(memory), "gym": round(gym_memory)},
        "gym_processes": gym.n,
        "versions": {
            "python": platform.python_version(),
            "mujoco": mujoco.__version__,
            "torch": torch.__version__,
            "gymnasium": gymnasium.__version__,
        },
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--body", default="crawl", choices=("crawl", "biped"))
    parser.add_argument("--preset", default="fast")
    parser.add_argument("--robots", type=int, help="the preset's own if left out")
    parser.add_argument("--threads", type=int, default=0, help="of the physics; 0 takes all")
    parser.add_argument("--rounds", type=int, default=6, help="turns of each, a few seconds each")
    parser.add_argument("--processes", type=int, nargs="+", default=[2, 8], help="tried for gym")
    parser.add_argument("--json", action="store_true", help="print one JSON object only")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        result = measure(args, Path(folder))
    if args.json:
        print(json.dumps(result, indent=1))
        return
    memory = result["memory_mb"] | {"raw": None}
    print(f"{args.body} {args.preset}: {result['robots']} robots, {result['threads']} threads")
    for name in ("train", "raw", "gym"):
        rate, cpu = result["steps_per_s"][name], result["cpu_us_per_step"][name]
        line = f"{name:6s} {rate:9.0f} env-steps/s  {cpu:8.1f} us of processor"
        if name != "train":
            key = f"train/{name}"
            line += (
                f"   {key} {result['ratios'][key]:.2f}, processor {result['cpu_ratios'][key]:.2f}"
            )
        if memory[name] is not None:
            line += f"   {memory[name]} MB"
        print(line)
    print(f"gym ran in {result['gym_processes']} processes; the training loop consists of")
    for name in PARTS:
        share, ms = result["shares"][name], result["ms_per_iteration"][name]
        print(f"  {name:10s} {100 * share:5.1f} %  {ms:8.1f} ms an iteration")


if __name__ == "__main__":
    main()
