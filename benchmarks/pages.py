"""The page in a browser: pictures of it for the docs, and how well the loop keeps time behind it.

    python benchmarks/pages.py --pictures                # docs/images/{drive,plots,replay}.png
    python benchmarks/pages.py --time --seconds 60       # benchmarks/results/pages.json

Both need Chromium and playwright. Chromium draws without a graphics card here, which takes every
core it can get: the worst company a real-time loop can have.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import chdir
from pathlib import Path
from typing import Any

from mobius.bridge.read_run import open_run
from mobius.drive.run import drive
from mobius.files import write_json_atomic
from mobius.mission import run as run_mission
from mobius.view.live.guard import Door
from mobius.view.live.nouns import Freeze, Go, Release
from mobius.view.replay import show

ROOT = Path(__file__).resolve().parents[1]
IMAGES, RESULTS = ROOT / "docs" / "images", ROOT / "benchmarks" / "results" / "pages.json"
ARGS = (
    "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
SIZE = (1200, 760)
"""Of the pictures [pixels]."""
CATCH_UP_S = 45.0
"""The page may be so far behind [s]."""
TABS_OF = {"drive.png": "twist", "plots.png": "power and forces"}
"""Tab of the plots that a picture of driving shows."""
SHOT_MS = 180_000
"""A picture may wait so long for a frame [ms]."""
Act = Callable[[Any, dict[str, Any]], None]


class Over(Exception):
    """The visit is over."""


def visit(start: Callable[..., Any], act: Act, *, size: tuple[int, int]) -> None:
    """Start a viewer, open its page in Chromium, and let ``act(page, state)`` do something.

    ``state["cockpit"]`` is the viewer's.
    """
    state: dict[str, Any] = {}

    def browse(address: str) -> None:
        from playwright.sync_api import sync_playwright

        try:
            with sync_playwright() as play:
                found = shutil.which("chromium") or shutil.which("chromium-browser")
                browser = play.chromium.launch(executable_path=found, args=list(ARGS))
                page = browser.new_page(viewport={"width": size[0], "height": size[1]})
                page.goto(address)
                while not (state.get("cockpit") and state["cockpit"].pulse.there):
                    time.sleep(0.1)
                act(page, state)
                browser.close()
        finally:
            state["over"] = True

    def ready(address: str) -> None:
        threading.Thread(target=browse, args=(address,), daemon=True).start()

    def seen(cockpit: Any) -> None:
        state["cockpit"] = cockpit
        if state.get("over"):
            raise Over

    try:
        start(ready=ready, seen=seen)
    except Over:
        return


def shoot(page: Any, state: dict[str, Any], picture: str) -> None:
    """Stop the time, and take the page's picture once it has caught up."""
    state["cockpit"].ask(Freeze(True))
    time.sleep(CATCH_UP_S)
    page.screenshot(path=IMAGES / picture, timeout=SHOT_MS)


def driving(picture: str, tab: str) -> Act:
    """Follow a plan for three metres with a tab of the plots open, and take the picture."""

    def act(page: Any, state: dict[str, Any]) -> None:
        cockpit = state["cockpit"]
        cockpit.tab = tab
        while cockpit.snapshot is None or cockpit.snapshot.t < 2.0:
            time.sleep(0.1)
        first = cockpit.snapshot.true_pose[0]
        while cockpit.snapshot.true_pose[0] < first + 3.0:
            if cockpit.snapshot.stopped:  # a page that hangs for long is gone
                cockpit.ask(Release())
            elif not cockpit.snapshot.following:
                cockpit.ask(Go(("crawl",)))
            time.sleep(0.02 if cockpit.snapshot.following else 1.0)
        shoot(page, state, picture)

    return act


def replaying(page: Any, state: dict[str, Any]) -> None:
    """Eight seconds of a run, and the picture."""
    while state["cockpit"].snapshot is None or state["cockpit"].snapshot.t < 8.0:
        time.sleep(0.02)
    shoot(page, state, "replay.png")


def picture(name: str) -> None:
    """Make one: ``drive.png``, ``plots.png`` or ``replay.png``."""
    if name != "replay.png":
        act = driving(name, TABS_OF[name])
        visit(
            lambda **k: drive("demo", door=Door(port=0), seconds=300.0, shadows=False, **k),
            act,
            size=SIZE,
        )
        return
    with tempfile.TemporaryDirectory() as folder:
        with chdir(folder):  # the page shows the path
            run_mission("demo", Path("runs/demo"), video=False)
            recorded = open_run("runs/demo")
        visit(
            lambda **k: show(recorded, port=0, seconds=300.0, shadows=False, **k),
            replaying,
            size=SIZE,
        )


def pictures() -> None:
    """All, a process each: Studio has one page a process."""
    for name in (*TABS_OF, "replay.png"):
        subprocess.run([sys.executable, __file__, "--picture", name], check=True)


def keeping(seconds: float) -> dict[str, Any]:
    """How well time was kept over some seconds of driving by keys, the page open all the while."""
    figures: dict[str, Any] = {}

    def watching(page: Any, state: dict[str, Any]) -> None:
        time.sleep(6.0)
        state["cockpit"].driving = True
        first = state["cockpit"].snapshot
        began = time.monotonic()
        while time.monotonic() - began < seconds:
            page.keyboard.down("ArrowLeft")
            time.sleep(2.0)
            page.keyboard.up("ArrowLeft")
            time.sleep(1.0)
        last, wall = state["cockpit"].snapshot, time.monotonic() - began
        rounds = [300.0 * first.t, 300.0 * last.t]
        missed = [s.keeping.misses * n for s, n in zip((first, last), rounds, strict=True)]
        figures.update(
            seconds=wall,
            real_time_factor=(last.t - first.t) / wall,
            deadlines_missed=(missed[1] - missed[0]) / (rounds[1] - rounds[0]),
            late_p99_ms=last.keeping.late_p99_ms,
            given_up_s=last.keeping.dropped_s - first.keeping.dropped_s,
            load_average=os.getloadavg()[0],
            cores=os.cpu_count(),
            mode=last.mode,
        )

    visit(
        lambda **k: drive("demo", door=Door(port=0), seconds=seconds + 200.0, shadows=False, **k),
        watching,
        size=(900, 640),
    )
    if not figures:
        raise RuntimeError("nothing was measured: the visit ended early; its own words stand above")
    return figures


def main() -> None:
    """Make the pictures, or measure."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--pictures", action="store_true")
    parser.add_argument("--picture", choices=[*TABS_OF, "replay.png"])
    parser.add_argument("--time", action="store_true")
    parser.add_argument("--seconds", type=float, default=60.0)
    options = parser.parse_args()
    if options.pictures:
        pictures()
    if options.picture:
        picture(options.picture)
    if options.time:
        result = keeping(options.seconds)
        print(json.dumps(result, indent=2))
        write_json_atomic(RESULTS, result)


if __name__ == "__main__":
    main()
