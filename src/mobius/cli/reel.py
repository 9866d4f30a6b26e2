"""``mobius reel``: films of the motions, and of all modes in one run."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from mobius.cli.common import Bar, at_least


@dataclass
class Reel:
    """Film one simulated run of all modes, or single motions; leaves video, sheet and JSON."""

    out: Path = Path("runs/reel")
    """Folder for the files; new or empty."""
    motion: tuple[str, ...] = ()
    """Single motions instead: prone_to_crawl, stand_to_crawl, crawl_to_stand, supine_to_crawl,
    supine_recovery, head_recovery, roll, push_ups; or all."""
    seed: int = 0
    """Seed of friction, mass, servo strength, delay and sensor noise; any whole number >= 0."""
    randomised: bool = True
    """Draw robot, floor and sensors from the seed; --no-randomised runs the drawing itself."""
    video: bool = True
    """Draw the video; --no-video leaves only sheet and JSON, which is quick."""

    def __call__(self) -> int:
        """Play, draw, and say where the files are; 1 where a run did not come to its end."""
        from mobius.headless import import_mujoco

        at_least("--seed", self.seed, 0)
        import_mujoco()
        from mobius.reel import SHOWS, play, write_show
        from mobius.reel.shows import REEL, show_of
        from mobius.results import staged
        from mobius.view.gl import gl_backend

        names = tuple(SHOWS) if "all" in self.motion else dict.fromkeys(self.motion)
        shows = [show_of(name) for name in names] or [REEL]
        gl_backend()  # says now, not after the run, that nothing can be drawn here
        failed, written = [], []
        with Bar() as bar, staged(self.out) as folder:
            for k, show in enumerate(shows):
                bar(f"play {show.name}", k / len(shows))
                footage = play(show, seed=self.seed, randomised=self.randomised)
                if footage.failed:
                    failed.append(f"{show.name}: {footage.failed}")
                files = write_show(
                    folder, show, footage, seed=self.seed, video=self.video, progress=bar
                )
                written += [file.name for file in files]
        for name in written:
            print(self.out / name)
        for line in failed:
            print(f"mobius: {line}", file=sys.stderr)
        return 1 if failed else 0
