"""Whether there is OpenGL is answered in one line that says what to do."""

import pytest

from mobius.errors import MobiusError
from mobius.view.gl import NoOpenGL, gl_available, gl_backend, last_line


def test_turned_off_is_said_to_be_turned_off(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "off")
    assert gl_available() == "MUJOCO_GL=off turns drawing off. Type: unset MUJOCO_GL"


def test_a_back_end_that_does_not_exist_is_tried_alone_and_named(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "nonsense")
    reason = gl_available()
    assert reason.startswith("no OpenGL context (nonsense: ")
    assert reason.endswith("Type: unset MUJOCO_GL")
    assert "\n" not in reason
    with pytest.raises(NoOpenGL, match="nonsense"):
        gl_backend()


def test_no_opengl_is_an_error_that_the_command_line_shows_in_one_line():
    assert issubclass(NoOpenGL, MobiusError)


def test_a_back_end_that_works_is_named(monkeypatch):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    reason = gl_available()
    if reason is not None:
        assert reason.startswith("no OpenGL context (")
        pytest.skip(reason)
    assert gl_backend() in ("egl", "osmesa", "cgl", "wgl")


def test_the_last_line_is_the_one_that_says_what_went_wrong():
    assert last_line("Traceback\n  File\nError: no display\n\n") == "Error: no display"
    assert last_line("  \n") == ""
    assert len(last_line("x" * 500)) == 160
