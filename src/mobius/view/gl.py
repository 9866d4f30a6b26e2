"""Is there OpenGL here, and which kind?

MuJoCo chooses its OpenGL back end when it is imported, from the variable ``MUJOCO_GL``.
By the time a video is wanted that import is long past. So nothing is ever drawn in this
process: drawing happens in a child (:mod:`mobius.view.render_worker`) that starts with
the right variable set, and the same child, asked to draw one pixel, answers whether a
back end works. A driver that crashes takes only the child with it.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys

from mobius.errors import MobiusError

__all__ = ["NoOpenGL", "gl_available", "gl_backend", "worker_command"]

_OFF = ("disable", "disabled", "off", "false", "0")
_BACKENDS = {"linux": ("egl", "osmesa"), "darwin": ("cgl",), "win32": ("wgl",)}
_PROBE_SECONDS = 60.0


class NoOpenGL(MobiusError):
    """No OpenGL context can be had here, so nothing can be drawn."""


def worker_command(*args: str) -> list[str]:
    """Command line that starts a drawing child with these arguments."""
    return [sys.executable, "-m", "mobius.view.render_worker", *args]


def gl_available() -> str | None:
    """None where OpenGL works, else why not and what to install, in one line.

    A ``MUJOCO_GL`` already set is the only back end tried. The first call takes a second
    or two, later ones nothing.
    """
    try:
        gl_backend()
    except NoOpenGL as error:
        return str(error)
    return None


def gl_backend() -> str:
    """Value of ``MUJOCO_GL`` with which drawing works. Raises :class:`NoOpenGL`."""
    result, reason = _probe(os.environ.get("MUJOCO_GL", "").lower().strip())
    if result is None:
        raise NoOpenGL(reason)
    return result


@functools.cache
def _probe(wanted: str) -> tuple[str | None, str]:
    if wanted in _OFF:
        return None, f"MUJOCO_GL={wanted} turns drawing off. Type: unset MUJOCO_GL"
    backends = (wanted,) if wanted else _BACKENDS.get(sys.platform, ("egl",))
    said = []
    for backend in backends:
        why = _try(backend)
        if why is None:
            return backend, ""
        said.append(f"{backend}: {why}")
    return None, f"no OpenGL context ({'; '.join(said)}). {_advice(wanted)}"


def _try(backend: str) -> str | None:
    """None when the child drew its pixel, else the last thing it said."""
    try:
        done = subprocess.run(
            worker_command("--probe"),
            env={**os.environ, "MUJOCO_GL": backend},
            capture_output=True,
            text=True,
            timeout=_PROBE_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"no answer in {_PROBE_SECONDS:.0f} s"
    if done.returncode == 0:
        return None
    return last_line(done.stderr) or f"exit code {done.returncode}"


def last_line(text: str) -> str:
    """The last line that says something, at most 160 characters."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1][:160] if lines else ""


def _advice(wanted: str) -> str:
    if wanted:
        return "Type: unset MUJOCO_GL"
    if sys.platform == "linux":
        return "Type: sudo apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri (or libosmesa6)"
    return "Install a graphics driver with OpenGL 1.5 or newer"
