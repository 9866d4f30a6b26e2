"""Import mujoco so that no OpenGL is touched.

MuJoCo loads the back end named by ``MUJOCO_GL`` when it is imported and fails where that one
does not work, though physics needs none. Pictures are drawn in child processes
(:mod:`mobius.view.gl`), which still see the variable as the user set it.
"""

from __future__ import annotations

import os


def import_mujoco() -> None:
    """Import mujoco with ``MUJOCO_GL=disable``, then put the variable back."""
    wanted = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        import mujoco  # noqa: F401
    finally:
        if wanted is None:
            del os.environ["MUJOCO_GL"]
        else:
            os.environ["MUJOCO_GL"] = wanted
