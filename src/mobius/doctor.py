"""What is installed, whether it works together, and what to type where it does not.

:func:`gather` looks (versions, one subprocess per package and per OpenGL back end, so
that a crash of one is a finding and not the end); :func:`diagnose` is pure and turns the
facts into findings; :func:`main` is the command line's verb.
"""

from __future__ import annotations

import importlib.metadata as metadata
import importlib.util
import json
import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from packaging.requirements import Requirement

from mobius.errors import InvalidInput

__all__ = ["Facts", "Finding", "Report", "diagnose", "examine", "gather", "main"]

Level = Literal["note", "warning", "error"]

PROBE_LIMIT_S = 60.0
"""A probe that has not answered by then counts as failed [s]."""

IMPORT_NAMES = {"pyyaml": "yaml", "pillow": "PIL", "imageio-ffmpeg": "imageio_ffmpeg"}
"""Distribution name to module name, where they differ by more than case."""

_USE = {
    "onnxruntime": "m.OrtValue.ortvalue_from_numpy(__import__('numpy').ones(2, 'f4')).numpy()",
    "imageio-ffmpeg": "m.get_ffmpeg_exe()",
}
"""A little more than an import, for packages that import and then fail."""

_GL_PROBE = """
import mujoco
xml = "<mujoco><worldbody><light pos='0 0 1'/><geom size='.1'/></worldbody></mujoco>"
model = mujoco.MjModel.from_xml_string(xml)
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
renderer = mujoco.Renderer(model, 16, 16)
renderer.update_scene(data)
assert renderer.render().any(), "the picture is black"
"""

_SPARSE_PROBE = """
import sys, mujoco
for path in sys.argv[1:]:
    if mujoco.mj_isSparse(mujoco.MjModel.from_xml_path(path)):
        print(path)
"""


@dataclass(frozen=True)
class Finding:
    """One thing that is worth knowing, with what to do about it."""

    level: Level
    about: str
    message: str


@dataclass(frozen=True)
class Facts:
    """What :func:`gather` saw."""

    mobius: str
    """Version of this package."""
    python: str
    platform: str
    cpus: int
    core: Mapping[str, str | None]
    """Version of every package that mobius needs; ``None`` if absent."""
    extras: Mapping[str, Mapping[str, str | None]]
    """The same per extra (train, dev)."""
    out_of_range: Mapping[str, str]
    """Installed package to the range that was asked for and is not met."""
    broken: Mapping[str, str]
    """Installed package to the last line of the error it gives when used."""
    gl: Mapping[str, str]
    """OpenGL back end to the last line of its error, ``""`` where it drew a picture."""
    gl_chosen: str
    """The variable MUJOCO_GL, ``""`` if unset."""
    sparse_models: tuple[str, ...]
    """Our MJCF files that MuJoCo would solve with sparse Jacobians."""
    model_error: str
    """Why the MJCF files could not be loaded, ``""`` if they were."""
    torch_cuda: str
    """CUDA version of the torch build, ``""`` for none."""
    gpu: bool
    """Whether an NVIDIA device is there."""


@dataclass(frozen=True)
class Report:
    """Facts and findings."""

    facts: Facts
    findings: tuple[Finding, ...]

    @property
    def exit_code(self) -> int:
        """1 if something essential is broken, else 0."""
        return int(any(f.level == "error" for f in self.findings))

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: ``ok``, ``facts``, ``findings``."""
        return {
            "ok": self.exit_code == 0,
            "facts": asdict(self.facts),
            "findings": [asdict(f) for f in self.findings],
        }

    def text(self) -> str:
        """The report for people, several lines."""
        f = self.facts
        lines = [f"mobius {f.mobius}, Python {f.python}, {f.platform}, {f.cpus} CPUs"]
        for title, packages in (("core", f.core), *f.extras.items()):
            named = (f"{name} {version or '(absent)'}" for name, version in packages.items())
            lines.append(f"{title}: {', '.join(named)}")
        drawn = (f"{name} {'works' if not why else f'no ({why})'}" for name, why in f.gl.items())
        lines.append(f"OpenGL: {', '.join(drawn)}")
        lines += [f"{x.level}: {x.about}: {x.message}" for x in self.findings]
        if not self.findings:
            lines.append("nothing to complain about")
        return "\n".join(lines)


def main(*, as_json: bool = False) -> int:
    """Print the report, for people or as one JSON object; returns the exit code."""
    report = examine()
    print(json.dumps(report.as_dict(), indent=2) if as_json else report.text())
    return report.exit_code


def examine() -> Report:
    """Look and judge; takes a few seconds."""
    facts = gather()
    return Report(facts, diagnose(facts))


def diagnose(facts: Facts) -> tuple[Finding, ...]:
    """Findings, gravest first; pure."""
    found = [*_packages(facts), *_combinations(facts), *_drawing(facts)]
    return tuple(sorted(found, key=lambda f: ("error", "warning", "note").index(f.level)))


def _packages(facts: Facts) -> list[Finding]:
    out = []
    for name, version in facts.core.items():
        if version is None:
            out.append(Finding("error", name, "is not installed. Type: make install"))
    for name, error in facts.broken.items():
        again = f"pip install --force-reinstall {name}"
        out.append(Finding("error", name, f"cannot be used ({error}). Type: {again}"))
    for name, wanted in facts.out_of_range.items():
        level: Level = "error" if name in facts.core else "warning"
        fix = f"pip install '{name}{wanted}'"
        out.append(Finding(level, name, f"is outside the range {wanted}. Type: {fix}"))
    for extra, packages in facts.extras.items():
        absent = [name for name, version in packages.items() if version is None]
        if absent:
            fix = f"pip install 'mobius[{extra}]'"
            text = f"lacks {', '.join(absent)}; to have it, type: {fix}"
            out.append(Finding("note", f"extra '{extra}'", text))
    return out


def _combinations(facts: Facts) -> list[Finding]:
    """Combinations known to be bad."""
    out = []
    if facts.model_error and not facts.broken.get("mujoco") and facts.core.get("mujoco"):
        text = f"does not load ({facts.model_error}). Type: make clean install"
        out.append(Finding("error", "robot model", text))
    if facts.core.get("mujoco") == "4.0.0" and facts.sparse_models:
        text = (
            f"4.0.0 solves sparse Jacobians wrongly and {', '.join(facts.sparse_models)} would"
            ' be sparse. Write: <option jacobian="dense"/>'
        )
        out.append(Finding("error", "mujoco", text))
    if facts.torch_cuda and not facts.gpu:
        text = (
            f"is built for CUDA {facts.torch_cuda} and there is no GPU: training works on the"
            " CPU, the CPU build would save some gigabytes"
        )
        out.append(Finding("note", "torch", text))
    return out


def _drawing(facts: Facts) -> list[Finding]:
    works = [name for name, error in facts.gl.items() if not error]
    if not works:
        text = "no back end draws, so runs leave no video. Debian: apt install libegl1 libgl1"
        return [Finding("warning", "OpenGL", text)]
    if facts.gl_chosen and facts.gl_chosen not in works:
        text = f"MUJOCO_GL={facts.gl_chosen} does not draw. Type: export MUJOCO_GL={works[0]}"
        return [Finding("warning", "OpenGL", text)]
    return []


# --- looking ----------------------------------------------------------------------------


def gather() -> Facts:
    """Versions from the installed metadata, the rest from subprocesses."""
    wanted = _requirements()
    versions = {r.name: _version(r.name) for group in wanted.values() for r in group}
    core = {r.name: versions[r.name] for r in wanted[""]}
    models = sorted((Path(__file__).parent / "model" / "mjcf").glob("*.xml"))
    with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as pool:
        broken = {name: pool.submit(_import_error, name) for name in core if core[name]}
        gl = {name: pool.submit(_run, _GL_PROBE, MUJOCO_GL=name) for name in _gl_names()}
        sparse = pool.submit(_run, _SPARSE_PROBE, *map(str, models))
    return Facts(
        mobius=_version("mobius") or "unknown",
        python=platform.python_version(),
        platform=platform.platform(terse=True) + " " + platform.machine(),
        cpus=os.cpu_count() or 1,
        core=core,
        extras={
            extra: {r.name: versions[r.name] for r in group}
            for extra, group in wanted.items()
            if extra
        },
        out_of_range={
            r.name: str(r.specifier)
            for group in wanted.values()
            for r in group
            if (version := versions[r.name]) and not r.specifier.contains(version, prereleases=True)
        },
        broken={name: error for name, job in broken.items() if (error := job.result()[1])},
        gl={name: job.result()[1] for name, job in gl.items()},
        gl_chosen=os.environ.get("MUJOCO_GL", ""),
        sparse_models=tuple(Path(line).name for line in sparse.result()[0].splitlines()),
        model_error=sparse.result()[1] if models else "no file model/mjcf/*.xml",
        torch_cuda=_torch_cuda(),
        gpu=Path("/dev/nvidiactl").exists(),
    )


def _requirements() -> dict[str, list[Requirement]]:
    """Requirements of mobius by extra; ``""`` holds the core."""
    try:
        extras = metadata.metadata("mobius").get_all("Provides-Extra") or []
    except metadata.PackageNotFoundError:
        raise InvalidInput(
            "mobius is on Python's path but not installed, so what it needs is unknown."
            " Type: make install"
        ) from None
    out: dict[str, list[Requirement]] = {"": [], **{extra: [] for extra in extras}}
    for requirement in map(Requirement, metadata.requires("mobius") or []):
        marker = requirement.marker
        if marker is None or marker.evaluate({"extra": ""}):
            out[""].append(requirement)
            continue
        for extra in extras:
            if marker.evaluate({"extra": extra}):
                out[extra].append(requirement)
    return out


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _gl_names() -> tuple[str, ...]:
    """Back ends worth trying on this platform."""
    if sys.platform == "darwin":
        return ("cgl",)
    if sys.platform == "win32":
        return ("wgl",)
    window = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return ("egl", "osmesa", "glfw") if window else ("egl", "osmesa")


def _import_error(name: str) -> tuple[str, str]:
    module = IMPORT_NAMES.get(name.lower(), name.replace("-", "_"))
    return _run(f"import {module} as m\n{_USE.get(name.lower(), '')}")


def _run(code: str, *args: str, **environment: str) -> tuple[str, str]:
    """Output of a small script, and the last line of its error or ``""``."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", code, *args],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=PROBE_LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "", f"no answer within {PROBE_LIMIT_S:g} s"
    if done.returncode == 0:
        return done.stdout, ""
    said = [line.strip() for line in done.stderr.splitlines() if line.strip()]
    return "", said[-1] if said else f"ended with code {done.returncode}"


def _torch_cuda() -> str:
    """CUDA version of the installed torch, read without importing it."""
    spec = importlib.util.find_spec("torch")
    if spec is None or spec.origin is None:
        return ""
    for line in (Path(spec.origin).parent / "version.py").read_text().splitlines():
        name, _, value = line.partition("=")
        if name.split(":")[0].strip() == "cuda":
            return value.strip().strip("'\"").replace("None", "")
    return ""
