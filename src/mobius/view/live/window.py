"""What Studio's own window needs before it opens.

MuJoCo Studio 4.0 draws its window through ``mujoco.rendering``, which asks for
``collections.abc.Buffer``: Python has it from 3.12 on. Its plain OpenGL mode names a target that
its renderer does not know; the mode that draws to pixels and puts them into the window works. And
where there is no display it ends the program.
"""

from __future__ import annotations

import abc
import collections.abc
import os
import sys

from mobius.errors import InvalidInput

WINDOW_GFX = "opengl_headless"
"""Graphics mode of the window."""


def check_window() -> None:
    """Whether a window can be opened here.

    Raises:
        InvalidInput: There is no display.
    """
    named = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not named:
        raise InvalidInput(
            "--viewer native: there is no display here (DISPLAY is not set); type --viewer web,"
            " or xvfb-run -a before the command"
        )


def prepare_window() -> None:
    """Load Studio's window; the name that Python 3.11 lacks is there meanwhile alone."""
    lacks = not hasattr(collections.abc, "Buffer")
    if lacks:
        setattr(collections.abc, "Buffer", _Buffer)  # noqa: B010
    try:
        from mujoco.studio import native_viewer  # noqa: F401
    finally:
        if lacks:
            delattr(collections.abc, "Buffer")


class _Buffer(abc.ABC):  # noqa: B024
    """Stands for ``collections.abc.Buffer``, whose instances Python 3.11 cannot know."""


for _kind in (bytes, bytearray, memoryview):
    _Buffer.register(_kind)
