"""``mobius replay``: look back at a recorded run."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from mobius.cli.common import at_least
from mobius.errors import InvalidInput, UnknownName

VIEWERS = ("web", "native")
"""Where a run can be looked at."""
LAST_PORT = 65535


@dataclass
class Replay:
    """Look at a recorded run with a time slider; --info prints what it holds."""

    run: Positional[Path]
    """Folder of a run, or a .mcap log; one cut off by a crash opens as far as it reads."""
    info: bool = False
    """Print duration, modes, way, falls and topics, and show nothing."""
    viewer: str = "web"
    """web (in the browser) or native (a window here)."""
    port: int = 8080
    """Port of the page on this machine, 1024 to 65535; 0 takes the first free one from 8080 on."""
    shadows: bool = True
    """Draw shadows; --no-shadows helps browsers without a graphics card."""

    def __call__(self) -> int:
        """Print or show."""
        if self.port != 0:
            at_least("--port", self.port, 1024)
        if self.port > LAST_PORT:
            raise InvalidInput(f"--port: expected at most {LAST_PORT}, got {self.port}")
        if self.viewer not in VIEWERS:
            raise UnknownName("viewer", self.viewer, VIEWERS)
        from mobius.bridge.describe import describe
        from mobius.bridge.read_run import open_run

        run = open_run(self.run)
        for note in run.notes:
            print(f"mobius: {note}", file=sys.stderr)
        if self.info:
            print("\n".join(describe(run)))
            return 0
        from mobius.view.replay import show

        show(run, viewer=self.viewer, port=self.port, shadows=self.shadows, ready=_tell)
        return 0


def _tell(address: str) -> None:
    print(f"open {address}", flush=True)
    print("Ctrl+C here ends it", flush=True)
