"""``mobius``: one command for everything. Each verb imports what it needs when it runs."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro
from tyro.conf import Positional

from mobius.errors import InvalidInput, MobiusError, UnknownName

XY = tuple[float, float]


@dataclass
class Demo:
    """Watch the robot crawl across the shipped two-room map; leaves report, video and log."""

    out: Path = Path("runs/demo")
    """Folder for the results; new, empty, or an older run, which is replaced."""
    seed: int = 0
    """Seed of friction, mass, delay and sensor drift; any whole number >= 0."""
    video: bool = True
    """Render video.mp4 (needs OpenGL; --no-video skips it)."""

    def __call__(self) -> int:
        """Drive the demo map."""
        return Run("demo", out=self.out, seed=self.seed, video=self.video).carry_out(replace=True)


@dataclass
class Run:
    """Plan a way over a map and drive it in physics; leaves report, video and log."""

    map: Positional[str]
    """A Nav2 map.yaml, a MovingAI .map, or the name of a shipped map (demo, arena)."""
    start: XY | None = None
    """Where the robot starts: x y [m] in the map frame; the map's own if left out."""
    goal: XY | None = None
    """Where it shall go: x y [m] in the map frame; the map's own if left out."""
    modes: tuple[str, ...] = ("crawl",)
    """Body modes the plan may use; so far: crawl."""
    seed: int = 0
    """Seed of friction, mass, delay and sensor drift; any whole number >= 0."""
    out: Path | None = None
    """Folder for the results, new or empty; runs/MAP_seedN if left out."""
    video: bool = True
    """Render video.mp4 (needs OpenGL; --no-video skips it)."""
    randomised: bool = True
    """Draw robot, floor and sensors from the seed; --no-randomised runs the drawing itself."""
    policy: Path | None = None
    """ONNX policy to walk with; the shipped one if left out."""

    def __call__(self) -> int:
        """Run the mission into a new folder."""
        return self.carry_out(replace=False)

    def carry_out(self, *, replace: bool) -> int:
        """Run the mission and say where the files are."""
        from mobius import mission
        from mobius.headless import import_mujoco

        _at_least("--seed", self.seed, 0)
        import_mujoco()
        out = self.out or Path("runs") / f"{Path(self.map).stem}_seed{self.seed}"
        with _Bar() as bar:
            outcome = mission.run(
                self.map,
                out,
                start=self.start,
                goal=self.goal,
                modes=self.modes,
                seed=self.seed,
                randomised=self.randomised,
                video=self.video,
                policy=self.policy,
                replace=replace,
                progress=bar,
            )
        s = outcome.summary
        verdict = "reached the goal" if s["goal_reached"] else "did NOT reach the goal"
        print(
            f"{verdict}: {s['final_distance_m']:.2f} m from it after {s['path_length_m']:.1f} m in"
            f" {s['sim_time_s']:.1f} s, {s['falls']} falls, {s['collisions']} collisions,"
            f" {s['energy_J']:.0f} J, {s['real_time_factor']:.1f} x real time"
        )
        print(
            f"plan {s['plan']['status']} (objective {s['plan']['objective']:g}, bound"
            f" {s['plan']['bound']:g}, {s['plan']['solve_ms']:.1f} ms)"
        )
        for name in ("report.html", "video.mp4", "run.mcap", "summary.json", "plan.json"):
            if name in outcome.files:
                print(f"{name:13s} {outcome.files[name]}")
        for note in outcome.notes:
            print(note, file=sys.stderr)
        return 0 if s["goal_reached"] else 1


@dataclass
class PlanVerb:
    """Plan on a map and print the plan: status, objective (higher is better), bound, steps.

    The objective is the repaired Table IV: cells seen earn, modes cost. ``mobius run`` plans the
    shortest way instead, with a cost near obstacles.
    """

    map: Positional[str]
    """A Nav2 map.yaml, a MovingAI .map, or the name of a shipped map."""
    start: XY | None = None
    """x y [m] in the map frame; the map's own if left out."""
    goal: XY | None = None
    """x y [m] in the map frame; the map's own if left out."""
    horizon: int | None = None
    """T: number of steps, >= 0; the fewest that reach the goal if left out."""
    modes: tuple[str, ...] = ("biped", "crawl", "roll")
    """Body modes the plan may use: biped, crawl, roll."""
    deadline: float = 2.0
    """Wall time for the search [s], > 0; the best plan by then is returned with its gap."""
    json: bool = False
    """Print one JSON object and nothing else."""

    def __call__(self) -> int:
        """Solve and print."""
        from mobius import mission
        from mobius.plan import NoPlan, build_problem, check, solve
        from mobius.results import plan_as_json

        if self.horizon is not None:
            _at_least("--horizon", self.horizon, 0)
        if not self.deadline > 0:
            raise InvalidInput(f"--deadline: expected seconds > 0, got {self.deadline}")
        world = mission.open_world(self.map, start=self.start, goal=self.goal)
        try:
            problem = build_problem(
                world.grid, horizon=self.horizon, modes=self.modes, must_reach=self.horizon is None
            )
            plan = solve(problem, deadline_s=self.deadline)
        except NoPlan as error:
            print(f"mobius: {error}", file=sys.stderr)
            if self.json:
                nothing = dict.fromkeys(("objective", "bound", "gap", "solve_ms"))
                print(json.dumps({"status": "infeasible", **nothing, "steps": []}))
            return 1
        check(problem, plan)
        result = plan_as_json(plan)
        if self.json:
            print(json.dumps(result))
        else:
            print(
                f"{plan.status}: objective {plan.objective:g}, bound {plan.bound:g}, gap"
                f" {plan.gap:g}, {result['solve_ms']:.1f} ms, {len(plan.modes)} steps"
            )
            for step in result["steps"]:
                print(f"{step['t']:4d}  {step['x']:8.2f} {step['y']:8.2f} m  {step['mode']}")
        return 0


@dataclass
class Train:
    """Learn a locomotion policy with PPO and export it as ONNX (needs mobius[train])."""

    body: Positional[str]
    """Which body learns: crawl or biped."""
    preset: str = "fast"
    """smoke (seconds, learns nothing) or fast (two cores; crawl a quarter of an hour)."""
    out: Path = Path("runs/train")
    """Run folder: checkpoint, progress, policy.onnx."""
    seed: int = 0
    """Seed of network, sampling and simulation; any whole number >= 0."""
    steps: int | None = None
    """Environment steps in all, > 0; the preset's own if left out."""
    threads: int = 0
    """CPU threads, >= 0; 0 takes all."""
    resume: bool = False
    """Continue the run in --out."""

    def __call__(self) -> int:
        """Train, export, say where."""
        import os
        from dataclasses import replace

        os.environ.setdefault("OMP_WAIT_POLICY", "passive")
        _need_train()
        from mobius.headless import import_mujoco

        import_mujoco()
        from mobius.train.export import export
        from mobius.train.learn import train
        from mobius.train.presets import preset_of

        preset = preset_of(self.body, self.preset)
        _at_least("--seed", self.seed, 0)
        _at_least("--threads", self.threads, 0)
        if self.steps is not None:
            _at_least("--steps", self.steps, 1)
            preset = replace(preset, steps=self.steps)
        with _Bar() as bar:

            def show(figures: dict[str, float]) -> None:
                done = figures["steps"] / preset.steps
                bar(
                    f"{figures['steps'] / 1e6:.2f}M steps {figures['steps_per_s']:.0f}/s"
                    f" error {figures['error/linear']:.3f} m/s {figures['error/yaw']:.3f} rad/s",
                    done,
                )

            train(
                preset,
                self.out,
                seed=self.seed,
                threads=self.threads,
                resume=self.resume,
                progress=show,
            )
        policy = self.out / "policy.onnx"
        difference = export(preset, self.preset, self.out, policy)
        print(f"{policy} (torch and onnxruntime differ by {difference:.1e})")
        return 0


@dataclass
class Eval:
    """Measure a policy in the whole stack over many seeds."""

    body: Positional[str]
    """Which body: crawl or biped."""
    what: Positional[str] = "tracking"
    """What to measure: tracking (commands held 4 s each, 20 s episodes)."""
    seeds: int = 100
    """Number of episodes, >= 1."""
    seed: int = 0
    """The first seed; any whole number >= 0."""
    policy: Path | None = None
    """ONNX policy; the shipped one if left out."""
    randomised: bool = True
    """Draw robot, floor and sensors from each seed."""
    workers: int = 0
    """Processes, >= 0; 0 takes one a CPU."""
    json: bool = False
    """Print one JSON object and nothing else."""

    def __call__(self) -> int:
        """Evaluate and print."""
        from mobius.evaluate import tracking
        from mobius.headless import import_mujoco

        if self.what != "tracking":
            raise UnknownName("evaluation", self.what, ("tracking",))
        _at_least("--seeds", self.seeds, 1)
        _at_least("--seed", self.seed, 0)
        _at_least("--workers", self.workers, 0)
        import_mujoco()
        with _Bar() as bar:
            seen = [0]

            def count(_: Any) -> None:
                seen[0] += 1
                bar("episodes", seen[0] / self.seeds)

            result = tracking(
                self.body,
                seeds=self.seeds,
                seed=self.seed,
                policy=self.policy,
                randomised=self.randomised,
                workers=self.workers,
                progress=count,
            )
        if self.json:
            print(json.dumps(result.as_json()))
            return 0
        mae, raw = result.mae, result.mae_raw
        print(f"{result.episodes} episodes of 20 s from seed {result.seed}: {result.falls} falls")
        print(
            f"mean abs. error  vx {mae['vx']:.4f} vy {mae['vy']:.4f} m/s  wz {mae['wz']:.4f} rad/s"
        )
        print(
            f"  unaveraged     vx {raw['vx']:.4f} vy {raw['vy']:.4f} m/s  wz {raw['wz']:.4f} rad/s"
        )
        print(
            f"power {result.power_W:.1f} W, torque over 95 % of stall in"
            f" {100 * result.saturation:.1f} % of joint-samples, loops open at most"
            f" {result.loop_residual_mm:.2f} mm"
        )
        return 0


@dataclass
class Bench:
    """Time the planner, the physics and the loop on this machine."""

    out: Path | None = None
    """Write the figures as JSON here as well."""

    def __call__(self) -> int:
        """Measure and print."""
        from mobius.bench import bench
        from mobius.headless import import_mujoco

        import_mujoco()
        figures = bench()
        for name, value in figures.items():
            print(f"{name:40s} {value:12.4g}")
        if self.out is not None:
            from mobius.files import write_json_atomic

            self.out.parent.mkdir(parents=True, exist_ok=True)
            write_json_atomic(self.out, figures)
        return 0


@dataclass
class Doctor:
    """Print versions, graphics and known-bad combinations, for bug reports."""

    json: bool = False
    """Print one JSON object and nothing else."""

    def __call__(self) -> int:
        """Examine this environment."""
        from mobius.doctor import main as doctor

        return int(doctor(as_json=self.json))


VERBS: dict[str, Callable[..., Any]] = {
    "demo": Demo,
    "run": Run,
    "plan": PlanVerb,
    "train": Train,
    "eval": Eval,
    "bench": Bench,
    "doctor": Doctor,
}


def _at_least(option: str, value: int, low: int) -> None:
    if value < low:
        raise InvalidInput(f"{option}: expected a whole number >= {low}, got {value}")


def _need_train() -> None:
    from importlib.util import find_spec

    from mobius.errors import MissingDependency

    for package in ("torch", "rsl_rl", "onnx"):
        if find_spec(package) is None:
            raise MissingDependency(package, "train", "training")


class _Bar:
    """A progress bar on standard error; silent where that is no terminal."""

    def __enter__(self) -> _Bar:
        from tqdm import tqdm

        self._bar = tqdm(total=100, unit="%", disable=None, leave=False, file=sys.stderr)
        return self

    def __call__(self, what: str, share: float) -> None:
        self._bar.set_description(what)
        self._bar.n = round(100 * share)
        self._bar.refresh()

    def __exit__(self, *_: object) -> None:
        self._bar.close()


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit code."""
    args = sys.argv[1:] if argv is None else argv
    try:
        if args and not args[0].startswith("-") and args[0] not in VERBS:
            raise UnknownName("verb", args[0], VERBS)
        verb = tyro.extras.subcommand_cli_from_dict(
            VERBS,
            prog="mobius",
            description="The software stack of a robot that walks, crawls, rolls and climbs.",
            args=args,
        )
        return int(verb())
    except MobiusError as error:
        print(f"mobius: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("mobius: stopped by the user; no half-written folder was left", file=sys.stderr)
        return 130


def entry() -> None:
    """Console script."""
    sys.exit(main())


if __name__ == "__main__":
    entry()
