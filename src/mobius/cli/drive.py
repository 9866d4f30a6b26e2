"""``mobius demo`` and ``mobius run``: over a map from start to goal."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tyro.conf import Positional

from mobius.cli.common import XY, Bar, at_least, place
from mobius.errors import InvalidInput


def map_and_modes(name: str, modes: Sequence[str]) -> tuple[str, tuple[str, ...]]:
    """Map and modes as meant: a map behind ``--modes crawl,biped`` is read as one more mode.

    Raises:
        InvalidInput: There is no map among them.
    """
    from mobius.mission import DRIVABLE

    known = {mode.value for mode in DRIVABLE}
    *before, last = modes or ("",)
    if not name and before and not set(last.split(",")) <= known:
        return last, tuple(before)
    if not name:
        raise InvalidInput("run: expected a map; type e.g. mobius run demo")
    return name, tuple(modes)


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

    map: Positional[str] = ""
    """A Nav2 map.yaml, a MovingAI .map, or the name of a shipped map (demo, arena,
    multimodal)."""
    start: XY | None = None
    """Where the robot starts: x y [m] in the map frame; the map's own if left out."""
    goal: XY | None = None
    """Where it shall go: x y [m] in the map frame; the map's own if left out."""
    modes: tuple[str, ...] = ("crawl",)
    """Body modes the plan may use, joined by commas: crawl, and with it biped and roll
    (crawl,biped,roll)."""
    regions: Path | None = None
    """YAML file of regions that force modes, laid over the map (docs/missions.md)."""
    scenario: Path | None = None
    """YAML file of obstacles that come, move and go during the run (docs/missions.md)."""
    costs: Path | None = None
    """Measured seconds and joules per metre, mode and change of body, a JSON file of
    mobius eval energy; the paper's if left out. Needs --per-s or --per-j."""
    per_s: float = 0.0
    """Points per second that a plan takes, >= 0; a cell costs 1 to 3."""
    per_j: float = 0.0
    """Points per joule that a plan takes, >= 0."""
    seed: int = 0
    """Seed of friction, mass, delay and sensor drift; any whole number >= 0."""
    out: Path | None = None
    """Folder for the results, new or empty; runs/MAP_seedN if left out."""
    video: bool = True
    """Render video.mp4 (needs OpenGL; --no-video skips it)."""
    randomised: bool = True
    """Draw robot, floor and sensors from the seed; --no-randomised runs the drawing itself."""
    policy: str | None = None
    """ONNX file, or flat or rough for a shipped policy; rough where the map is, if left out."""

    def __call__(self) -> int:
        """Run the mission into a new folder."""
        return self.carry_out(replace=False)

    def carry_out(self, *, replace: bool) -> int:
        """Run the mission and say where the files are."""
        from mobius import mission
        from mobius.headless import import_mujoco

        at_least("--seed", self.seed, 0)
        place("--start", self.start)
        place("--goal", self.goal)
        name, modes = map_and_modes(self.map, self.modes)
        import_mujoco()
        out = self.out or Path("runs") / f"{Path(name).stem}_seed{self.seed}"
        with Bar() as bar:
            outcome = mission.run(
                name,
                out,
                start=self.start,
                goal=self.goal,
                modes=modes,
                regions=self.regions,
                scenario=self.scenario,
                costs=self.costs,
                per_s=self.per_s,
                per_J=self.per_j,
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
        self._tell_modes(s)
        for name in ("report.html", "video.mp4", "run.mcap", "summary.json", "plan.json"):
            if name in outcome.files:
                print(f"{name:13s} {outcome.files[name]}")
        for note in outcome.notes:
            print(note, file=sys.stderr)
        return 0 if s["goal_reached"] else 1

    def _tell_modes(self, s: dict[str, Any]) -> None:
        """Modes, rolls, recoveries and new plans, where there was more than crawling."""
        if len(s["modes"]) > 1:
            energy = ", ".join(f"{m} {row['energy_J']:.0f} J" for m, row in s["modes"].items())
            print(
                f"modes: {energy}; {s['mode_switches']['driven_per_step']:.2f} switches per step,"
                f" {s['rolls']} rolls, {s['recoveries']} of {s['falls']} falls recovered"
            )
        for r in s["replans"]:
            print(f"new plan at {r['t']:.1f} s ({r['why']}): {r['problem'] or r['status']}")
