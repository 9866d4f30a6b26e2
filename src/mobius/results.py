"""The folder a run leaves: report, video, log, plan, summary; whole or not there.

Everything is written into a hidden folder beside the one asked for, which gets its name by
one rename at the end. A kill at any moment leaves the old folder, the new one, or none.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from mobius.bridge.about import About
from mobius.bridge.record import McapRecorder
from mobius.errors import InvalidInput, MobiusError
from mobius.files import write_json_atomic
from mobius.model.urdf import build_urdf
from mobius.robot import TICK
from mobius.stack import FRAME_EVERY, Judge, RunRecord
from mobius.types import Mode, Plan, Pose
from mobius.world import World

FILES = ("plan.json", "run.mcap", "video.mp4", "report.html", "summary.json")
"""Everything a run may leave."""

Progress = Callable[[str, float], None]
"""Called with what is going on and how much of it is done (0 to 1)."""


@contextmanager
def staged(out: Path, *, replace: bool = False) -> Iterator[Path]:
    """A folder to write into that becomes ``out`` when the block ends without an error.

    Args:
        out: New or empty folder; with ``replace`` it may hold an older run and nothing else.
        replace: Whether an older run is replaced.

    Raises:
        InvalidInput: ``out`` holds something, or cannot be made here.
    """
    held = {p.name for p in out.iterdir()} if out.is_dir() else set()
    if out.exists() and (not out.is_dir() or held - (set(FILES) if replace else set())):
        raise InvalidInput(f"{out} exists and is not empty; choose another --out")
    stage = out.parent / f".{out.name}.{os.getpid()}.partial"
    try:
        stage.mkdir(parents=True)
    except OSError as error:
        raise InvalidInput(
            f"{out} cannot be written ({error.strerror}); choose another --out"
        ) from None
    try:
        yield stage
        if out.exists():
            old = out.parent / f".{out.name}.{os.getpid()}.old"
            out.rename(old)
            stage.rename(out)
            shutil.rmtree(old)
        else:
            stage.rename(out)
    finally:
        shutil.rmtree(stage, ignore_errors=True)


def plan_as_json(plan: Plan, later: Sequence[Plan] = ()) -> dict[str, Any]:
    """Status, objective, bound, gap, solve time [ms] and steps with metres and mode.

    Step t is where the robot is after t moves; ``mode`` is the one that brought it there.
    Plans made on the way stand in a list ``later``, where there are some.
    """
    modes = [plan.modes[0] if plan.modes else Mode.CRAWL, *plan.modes]
    more = {"later": [plan_as_json(p) for p in later]} if later else {}
    return {
        "status": plan.status,
        "objective": plan.objective,
        "bound": plan.bound,
        "gap": plan.gap,
        "solve_ms": 1e3 * plan.solve_s,
        "steps": [
            {"t": t, "x": float(x), "y": float(y), "mode": mode.value}
            for t, ((x, y), mode) in enumerate(zip(plan.xy_M, modes, strict=True))
        ],
        **more,
    }


def build_log(
    world: World,
    plan: Plan,
    judge: Judge,
    *,
    about: About | None = None,
    later: Sequence[tuple[float, Plan]] = (),
    mocap: Sequence[Any] = (),
) -> McapRecorder:
    """Every sample of a run as ROS messages, with the truth beside it; odom is map.

    Args:
        world: As it is at the end.
        plan: The first.
        judge: Who watched the run.
        about: What was run.
        later: Plans made on the way, and when [s].
        mocap: (c, 7) poses of the scene's movable obstacles, per video frame.
    """
    recorder = McapRecorder(about=about)
    here = Pose(p=[0.0, 0.0, 0.0], q=[1.0, 0.0, 0.0, 0.0])  # type: ignore[arg-type]
    recorder.once(grid=world.grid, plan=plan, pose_MO=here, description=build_urdf())
    for t, new in later:
        recorder.once(stamp=t, plan=new)
    for k, poses in enumerate(mocap):
        if len(poses) and (k == 0 or (poses != mocap[k - 1]).any()):
            recorder.once(stamp=k * FRAME_EVERY * TICK, obstacles=poses)
    for sample, truth in zip(judge.samples, judge.truths, strict=True):
        recorder.see(sample, truth)
    return recorder


def about_run(summary: Mapping[str, Any], judge: Judge, scene: str) -> About:
    """What the log says of the run as a whole."""
    return About(
        map=summary.get("map", ""),
        seed=summary.get("seed"),
        variation=asdict(judge.robot.variation),
        versions=summary.get("versions", {}),
        scene=scene,
    )


def write_results(
    folder: Path,
    world: World,
    record: RunRecord,
    judge: Judge,
    model: Any,
    *,
    scene: str = "",
    later: Sequence[tuple[float, Plan]] = (),
    mocap: Sequence[Any] | None = None,
    video: bool,
    progress: Progress | None,
) -> tuple[list[str], list[str]]:
    """Write the files of a run.

    Args:
        folder: Where to.
        world: As it is at the end.
        record: The run.
        judge: Who watched it.
        model: The scene.
        scene: The same as MJCF, for the log.
        later: Plans made on the way, and when [s].
        mocap: (c, 7) poses of the scene's movable obstacles, per video frame.
        video: Whether to render.
        progress: Told how much is rendered.

    Returns:
        Names of the files, and what went otherwise than asked.
    """
    from mobius.view.report import write_report

    names, notes = ["plan.json", "run.mcap"], []
    plans = [plan for _, plan in later]
    write_json_atomic(folder / "plan.json", plan_as_json(record.plan, plans))
    log = build_log(
        world,
        record.plan,
        judge,
        about=about_run(record.summary, judge, scene),
        later=later,
        mocap=() if mocap is None else mocap,
    )
    log.save(folder / "run.mcap")
    still = None
    if video:
        try:
            still = _still(record, model)
            _video(folder / "video.mp4", record, model, progress, mocap)
            names.append("video.mp4")
        except MobiusError as error:
            notes.append(f"no video: {error}")
    beside = [*names, "summary.json"]
    write_report(
        folder / "report.html",
        record,
        occupancy=world.occupancy,
        later=plans,
        still=still,
        files=beside,
    )
    write_json_atomic(folder / "summary.json", record.summary)
    return [*names, "report.html", "summary.json"], notes


def _painting(record: RunRecord) -> dict[str, Any]:
    """Plan and true path for pictures."""
    return {
        "plan_xy": record.plan.xy_M,
        "plan_modes": [m.value for m in record.plan.modes],
        "path_true": record.true_p[::2, :2],
    }


def _still(record: RunRecord, model: Any) -> Any:
    from mobius.view.video import render_still

    middle = len(record.frame_qpos) // 2
    return render_still(model, record.frame_qpos[middle], size=(640, 360), **_painting(record))


def _video(
    path: Path,
    record: RunRecord,
    model: Any,
    progress: Progress | None,
    mocap: Sequence[Any] | None,
) -> None:
    from mobius.view.video import render_video

    def tell(done: int, total: int) -> None:
        if progress is not None:
            progress("video", done / total)

    modes = record.modes[::2][: len(record.frame_t)]
    captions = [f"{t:5.1f} s  {mode}" for t, mode in zip(record.frame_t, modes, strict=True)]
    render_video(
        path,
        model,
        record.frame_qpos,
        qpos_fps=1.0 / (FRAME_EVERY * TICK),
        captions=captions,
        mocap=mocap if mocap is not None and model.nmocap else None,
        progress=tell,
        **_painting(record),
    )
