"""A show as files: NAME.mp4, NAME.png with its moments, NAME.json with its events."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from mobius.files import write_json_atomic
from mobius.modes.machine import WALKING
from mobius.reel.film import FPS, Footage
from mobius.reel.shows import Show
from mobius.types import LIMBS, Mode
from mobius.view.camera import ChaseCamera
from mobius.view.sheet import draw_moments, write_sheet
from mobius.view.stage import stage_model
from mobius.view.video import render_video

Progress = Callable[[str, float], None]

SIZE = (640, 360)
"""Of the video [px]."""
SIDE = ChaseCamera(distance=1.15, elevation=0.2, side=1.25, smooth=0.5)
"""From the right side and low, so that what touches the floor is seen."""
COLUMNS = 5
_CLOSER = 0.75
"""Share of what happens, against time, in the choice of frames."""
BEFORE_S = 0.2
"""A sheet begins this long before the motion and ends this long after it [s]."""
_LABEL = {
    Mode.CRAWL: "crawl",
    Mode.BIPED: "two legs",
    Mode.ROLL: "roll",
    Mode.GATHER: "gather",
    Mode.STAND_UP: "stand up",
    Mode.LIE_DOWN: "lie down",
    Mode.RECOVER: "recover",
    Mode.PUSH_UPS: "push-ups",
    Mode.STOP: "stop",
}


def captions(footage: Footage) -> list[str]:
    """One line for each frame: time and mode."""
    pairs = zip(footage.t, footage.modes, strict=True)
    return [f"{t:5.1f} s  {_LABEL.get(mode, mode.value)}" for t, mode in pairs]


def stretches(footage: Footage) -> list[tuple[Mode, int, int]]:
    """(mode, first frame, frame after the last) of everything the robot was in."""
    found, at = [], 0
    for mode, group in groupby(footage.modes):
        count = len(list(group))
        found.append((mode, at, at + count))
        at += count
    return found


def telling(footage: Footage, first: int, last: int, count: int) -> list[int]:
    """``count`` frames from the first to the last, closer together where more happens.

    Evenly spaced by a blend of time and of the way that trunk and joints turn.
    """
    time = np.linspace(0.0, 1.0, last - first + 1)
    turned = np.linalg.norm(np.diff(footage.qpos[first : last + 1, 3:], axis=0), axis=1)
    way = np.append(0.0, np.cumsum(turned))
    blend = time if way[-1] == 0.0 else (1.0 - _CLOSER) * time + _CLOSER * way / way[-1]
    at = np.interp(np.linspace(0.0, 1.0, count), blend, np.arange(first, last + 1))
    return np.unique(at.round().astype(int)).tolist()


def motion_rows(footage: Footage, count: int) -> list[int]:
    """Frames of the motion alone; of the whole run where it has none."""
    moving = [k for k, mode in enumerate(footage.modes) if mode not in WALKING]
    pad = round(BEFORE_S * FPS)
    first = max(moving[0] - pad, 0) if moving else 0
    last = min(moving[-1] + pad, len(footage.t) - 1) if moving else len(footage.t) - 1
    return telling(footage, first, last, count)


def reel_rows(footage: Footage) -> list[int]:
    """Frames that tell a long run: one of each walk, several of each motion."""
    rows: list[int] = []
    for mode, first, end in stretches(footage):
        if mode in WALKING:
            rows.append((first + end) // 2)
        elif mode is Mode.PUSH_UPS:  # down and up again, whatever the time that takes
            height = footage.qpos[first:end, 2]
            low = int(np.argmin(height))
            rows += [first + low, first + low + int(np.argmax(height[low:]))]
        else:
            count = 5 if mode in (Mode.ROLL, Mode.RECOVER) else 3
            rows += telling(footage, first, end - 1, count + 2)[1:-1]
    return rows


def as_json(show: Show, footage: Footage, seed: int) -> dict[str, Any]:
    """What happened, as plain values."""
    acts = [
        {
            "mode": act.mode.value,
            "twist": list(act.twist),
            "shove_mps": None if act.shove is None else list(act.shove),
            "begins_s": round(float(footage.t[footage.acts.index(k)]), 3)
            if k in footage.acts
            else None,
        }
        for k, act in enumerate(show.acts)
    ]
    return {
        "name": show.name,
        "what": show.what,
        "seed": seed,
        "complete": not footage.failed,
        "why": footage.failed,
        "seconds": round(float(footage.t[-1]), 3),
        "acts": acts,
        "events": [
            {"stamp_s": round(e.stamp, 3), "before": e.before, "after": e.after, "why": e.why}
            for e in footage.events
        ],
        "limbs": list(LIMBS),
        "faults": {
            mode.value: {
                "into_floor_m": f.into_floor,
                "into_itself_m": f.into_itself,
                "slid_m": f.slid.tolist(),
                "pressed_s": f.pressed_s.tolist(),
            }
            for mode, f in footage.faults.items()
        },
    }


def write_show(
    folder: Path,
    show: Show,
    footage: Footage,
    *,
    seed: int,
    size: tuple[int, int] = SIZE,
    video: bool = True,
    progress: Progress | None = None,
) -> list[Path]:
    """Write the files of one show; returns them.

    Args:
        folder: Where to.
        show: What was played.
        footage: The run.
        seed: It was drawn from.
        size: Of the video [px]; frames of the sheet have half of it.
        video: Whether to draw the video too.
        progress: Called with the share done.

    Raises:
        NoOpenGL: Nothing can be drawn here.
    """
    files = [folder / f"{show.name}.{kind}" for kind in ("mp4", "png", "json")]
    lines = captions(footage)
    rows = reel_rows(footage) if show.name == "reel" else motion_rows(footage, 2 * COLUMNS)
    model = stage_model()
    if video:

        def tell(done: int, count: int) -> None:
            if progress is not None:
                progress(f"draw {show.name}", done / count)

        render_video(
            files[0],
            model,
            footage.qpos,
            qpos_fps=FPS,
            fps=FPS,
            size=size,
            captions=lines,
            camera=SIDE,
            progress=tell,
        )
    pictures = draw_moments(
        model,
        footage.qpos,
        rows,
        captions=[lines[k] for k in rows],
        qpos_fps=FPS,
        size=(size[0] // 2, size[1] // 2),
        camera=SIDE,
    )
    write_sheet(files[1], pictures, columns=COLUMNS)
    write_json_atomic(files[2], as_json(show, footage, seed))
    return files if video else files[1:]
