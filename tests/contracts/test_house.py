"""The house around the rooms: version, Makefile, wording, and a README that tells the truth."""

import ast
import importlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from functools import cache
from itertools import takewhile
from pathlib import Path

import pytest

import mobius

ROOT = Path(__file__).parents[2]
DOCUMENTS = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").glob("*.md")),
]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def blocks(language: str) -> list[tuple[str, str]]:
    """(document, code) of every fenced block of a language in README and docs."""
    pattern = re.compile(rf"^```{language}\n(.*?)^```", re.DOTALL | re.MULTILINE)
    return [
        (document.name, code)
        for document in DOCUMENTS
        if document.exists()
        for code in pattern.findall(document.read_text())
    ]


def commands() -> list[tuple[str, ...]]:
    """Every ``mobius ...`` line of a shell block, as words without its comment."""
    lines = [
        line.removeprefix("$ ").strip()
        for language in ("bash", "sh", "console")
        for _, code in blocks(language)
        for line in code.replace("\\\n", " ").splitlines()
    ]
    return [tuple(shlex.split(x, comments=True)) for x in lines if x.startswith("mobius ")]


def links() -> list[tuple[str, str]]:
    """(document, target) of every link to a file."""
    pattern = re.compile(r"\]\((?!https?:|#|mailto:)([^)#]+)")
    return [
        (str(document.relative_to(ROOT)), target)
        for document in DOCUMENTS
        if document.exists()
        for target in pattern.findall(document.read_text())
    ]


def short(value: str) -> str:
    """A test id: the first line of a parameter."""
    return value.partition("\n")[0] or "none"


@cache
def help_of(words: tuple[str, ...]) -> str:
    """What ``mobius WORDS --help`` prints."""
    done = subprocess.run(
        [sys.executable, "-c", "from mobius.cli import main; main()", *words, "--help"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "COLUMNS": "200", "NO_COLOR": "1"},
    )
    assert done.returncode == 0, f"mobius {' '.join(words)} --help: {done.stderr or done.stdout}"
    return done.stdout


def tracked_files() -> list[Path]:
    """Files that git has or would take."""
    if not shutil.which("git") or not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return [path for name in listed.stdout.split("\0") if name and (path := ROOT / name).is_file()]


def test_the_version_is_the_projects():
    assert mobius.__version__ == PYPROJECT["project"]["version"]


def test_the_changelog_knows_the_version():
    version = re.escape(PYPROJECT["project"]["version"])
    assert re.search(rf"^## \[{version}\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)


def test_what_is_exported_is_there():
    source = ast.parse((ROOT / "src" / "mobius" / "__init__.py").read_text())
    names = [a.asname for n in source.body if isinstance(n, ast.ImportFrom) for a in n.names]
    assert "Plan" in names
    assert all(hasattr(mobius, name) for name in names)


def test_no_file_names_a_place_on_somebodys_machine():
    # written in two halves, so that this file does not name one either
    places = ["/" + "work/", "/" + "root/", "/" + "home/", "." + "pyenv", "/" + "Users/"]
    found = []
    for path in tracked_files():
        try:
            text = path.read_text()
        except UnicodeDecodeError:
            continue
        found += [f"{path.relative_to(ROOT)}: {place}" for place in places if place in text]
    assert not found


def test_every_pinned_version_satisfies_what_the_project_asks_for():
    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pins = dict(line.split("==") for line in lines if line and not line.startswith("#"))
    project = PYPROJECT["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    for requirement in (Requirement(line) for group in groups for line in group):
        pin = pins[canonicalize_name(requirement.name)]
        assert requirement.specifier.contains(pin), f"{requirement} but pinned {pin}"


@pytest.mark.parametrize("verb", ["install", "demo", "test", "check", "bench", "train", "clean"])
def test_make_knows_the_verb_and_the_help_tells_it(verb):
    make = shutil.which("make")
    if make is None:
        pytest.skip("make is not installed")
    plan = subprocess.run(
        [make, "--dry-run", verb], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert plan.returncode == 0, plan.stderr
    told = subprocess.run([make, "help"], cwd=ROOT, capture_output=True, text=True, check=True)
    assert f"make {verb} " in told.stdout


@pytest.mark.parametrize(("document", "code"), blocks("python") or [("", "")], ids=short)
def test_python_in_the_documents_parses_and_imports_what_exists(document, code):
    if not code:
        pytest.skip("no Python in the documents")
    for node in ast.walk(ast.parse(code, document)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                importlib.import_module(alias.name)
        elif isinstance(node, ast.ImportFrom) and node.module:
            module = importlib.import_module(node.module)
            for alias in node.names:
                if not hasattr(module, alias.name):
                    importlib.import_module(f"{node.module}.{alias.name}")


@pytest.mark.parametrize("words", commands() or [()], ids=" ".join)
def test_commands_in_the_documents_exist_with_their_options(words):
    if not words:
        pytest.skip("no mobius command in the documents")
    verb = tuple(takewhile(re.compile(r"[a-z][a-z0-9-]*").fullmatch, words[1:]))
    text = help_of(verb)
    for option in (w.split("=")[0] for w in words if w.startswith("--")):
        known = re.search(rf"{re.escape(option)}(?![\w-])", text)
        assert known, f"{' '.join(words)}: {option} is not in its help"


@pytest.mark.parametrize(("document", "target"), links() or [("", "")], ids=short)
def test_links_between_the_documents_lead_somewhere(document, target):
    if not target:
        pytest.skip("no links in the documents")
    assert (ROOT / document).parent.joinpath(target).exists()


def test_every_row_that_the_code_cites_is_in_the_table_of_contradictions():
    told = set(re.findall(r"^\| (\d+) \|", (ROOT / "docs/paper-to-code.md").read_text(), re.M))
    for name in ("paper.py", "model/fatigue.py"):
        text = (ROOT / "src" / "mobius" / name).read_text()
        for first, last in re.findall(r"\b[Rr]ows? (\d+)(?:-(\d+))?", text):
            cited = {str(n) for n in range(int(first), int(last or first) + 1)}
            assert cited <= told, f"{name} cites rows {sorted(cited - told)}"


def test_the_documents_tell_the_topics_and_joints_that_are_really_there():
    from mobius.bridge.table import heard_table, said_table
    from mobius.model.joints import JOINTS

    ros2, text = ((ROOT / "docs" / f"{n}.md").read_text() for n in ("ros2", "conventions"))
    assert said_table() in ros2
    assert heard_table() in ros2
    joints = re.findall(r"`((?:left|right)_[a-z_]+)`", text.split("## Joints")[1])
    assert tuple(joints) == JOINTS
