"""``mobius drive``: take the controls, in the browser or in a window."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Literal

from tyro.conf import Positional

from mobius.cli.common import at_least
from mobius.errors import InvalidInput


@dataclass
class Drive:
    """Drive the robot live: in the browser, in a window, or with nobody watching."""

    map: Positional[str] = "demo"
    """A Nav2 map.yaml, a MovingAI .map, or the name of a shipped map."""
    viewer: Literal["web", "native", "none"] = "web"
    """Page in the browser, window on this machine's screen, or neither."""
    port: int = 8080
    """Of the page; 0 takes the first free one from 8080 on."""
    host: str = "127.0.0.1"
    """Address the page is served on. Beyond this machine a token is asked of everybody."""
    token: str = ""
    """The token to ask for, at least 16 characters; that of the environment (MOBIUS_TOKEN, which
    other users cannot read), else one that is drawn and printed, if left out."""
    seconds: float | None = None
    """End after so many seconds of wall time; when the program is ended if left out."""
    seed: int = 0
    """Seed of friction, mass, delay and sensor drift; any whole number >= 0."""
    randomised: bool = True
    """Draw robot, floor and sensors from the seed; --no-randomised runs the drawing itself."""
    shadows: bool = True
    """Draw shadows; --no-shadows helps browsers without a graphics card."""
    robot: Literal["sim", "real"] = "sim"
    """What is driven: the simulated robot."""

    def __call__(self) -> int:
        """Run until it is ended."""
        from mobius.headless import import_mujoco

        at_least("--seed", self.seed, 0)
        if self.robot == "real" and self.viewer == "web":
            raise InvalidInput(
                "--robot real --viewer web: a page must not move a real robot; type --viewer native"
            )
        if self.robot == "real":
            raise InvalidInput("--robot real: there is no servo driver yet; type --robot sim")
        if self.seconds is not None and not 0.0 < self.seconds < 1e6:
            raise InvalidInput(f"--seconds: expected a number > 0, got {self.seconds}")
        if self.viewer != "native":
            import_mujoco()
        from mobius.drive.run import drive
        from mobius.view.live.guard import Door, is_loopback, new_token

        token = self.token or os.environ.get("MOBIUS_TOKEN", "")
        if not token and not is_loopback(self.host):
            token = new_token()
        door = Door(self.host, self.port, token)
        driven = drive(
            self.map,
            viewer=self.viewer,
            door=door,
            seconds=self.seconds,
            seed=self.seed,
            randomised=self.randomised,
            shadows=self.shadows,
            ready=self._tell,
        )
        if driven.last is not None:
            keeping = driven.last.keeping
            print(
                f"drove {driven.last.t:.1f} s; real time x {keeping.factor:.3f}, 300 Hz deadlines"
                f" missed {100 * keeping.misses:.2f} %, given up {keeping.dropped_s:.2f} s"
            )
        return 0

    def _tell(self, address: str) -> None:
        print(f"open {address}", flush=True)
        print("simulation only; Ctrl+C here ends it", flush=True)
