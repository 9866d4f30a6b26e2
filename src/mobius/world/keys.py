"""A yaml mapping that can say in which file and line a wrong key stands."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml

from mobius.errors import MapError, did_you_mean

_MAX_SHOWN = 40
MAP = "a map.yaml"
"""What :func:`read_yaml` reads, if not told otherwise."""


def shown(text: object) -> str:
    """A value of the user's, quoted, on one line and not too long."""
    flat = " ".join(str(text).split())
    return f"'{flat[:_MAX_SHOWN]}...'" if len(flat) > _MAX_SHOWN else f"'{flat}'"


def read_yaml(path: Path, *, what: str = MAP, first: str = "image: ...") -> Section:
    """Read one yaml file that holds a mapping.

    Args:
        path: Where it is.
        what: What the file should be, for messages.
        first: How such a file may start, for messages.

    Raises:
        MapError: The file is missing, not text, not yaml, or not a mapping.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        near = [p.name for p in path.parent.glob("*.yaml")] if path.parent.is_dir() else []
        raise MapError(
            f"{path}: there is no such file.{did_you_mean(path.name, near)}"
            + (
                " Check the path, or name a map that ships with mobius"
                if what == MAP
                else f" Check the path; expected {what}"
            )
        ) from None
    except OSError as e:
        raise MapError(f"{path}: cannot be read ({e.strerror}); check the path") from None
    except UnicodeDecodeError as e:
        raise MapError(
            f"{path}, byte {e.start}: expected UTF-8 text, got a binary file; name {what}"
        ) from None
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as e:
        line = e.problem_mark.line + 1 if e.problem_mark else 1
        raise MapError(
            f"{path}, line {line}: not valid yaml ({e.problem or e.context}); correct this line"
        ) from None
    except (yaml.YAMLError, RecursionError, ValueError) as e:
        problem = str(e).splitlines()[0] if str(e) else type(e).__name__
        raise MapError(f"{path}: not valid yaml ({problem}); write it again") from None
    if not isinstance(node, yaml.MappingNode):
        raise MapError(
            f"{path}, line 1: expected 'key: value' lines of {what}, got"
            f" {'an empty file' if node is None else 'something else'}; start with '{first}'"
        )
    return Section(node, path)


class Section:
    """One mapping of a yaml file; every ``get`` checks what it returns.

    Numbers and texts are read from the written scalar, so ``1e-2``, ``0.01`` and
    ``"0.01"`` are the same number, as they are to Nav2.
    """

    def __init__(self, node: yaml.MappingNode, file: Path, *, path: str = "") -> None:
        self.file = file
        self.path = path
        self._lines: dict[str, int] = {}
        self._nodes: dict[str, yaml.Node] = {}
        self.line = node.start_mark.line + 1
        for key, value in node.value:
            line = key.start_mark.line + 1
            if not isinstance(key, yaml.ScalarNode):
                raise MapError(f"{file}, line {line}: expected a plain key such as 'image'")
            if key.value in self._nodes:
                raise MapError(
                    f"{file}, line {line}, key {shown(path + key.value)}: written twice;"
                    " remove one of them"
                )
            self._lines[key.value] = line
            self._nodes[key.value] = value

    def __contains__(self, key: object) -> bool:
        return key in self._nodes

    def __iter__(self) -> Iterator[str]:
        return iter(self._nodes)

    def error(self, key: str, problem: str) -> MapError:
        """The one-line error of a key: file, line, key, problem and fix."""
        line = self._lines.get(key, self.line)
        return MapError(f"{self.file}, line {line}, key {shown(self.path + key)}: {problem}")

    def only(self, known: Sequence[str]) -> None:
        """Raise on any key that is not known."""
        for key in self._nodes:
            if key not in known:
                raise self.error(
                    key, f"unknown.{did_you_mean(key, known)} Known: {', '.join(known)}"
                )

    def no_typos(self, known: Sequence[str]) -> None:
        """Raise on keys that look like a known one misspelt; other unknown keys may stay."""
        for key in self._nodes:
            if key in known:
                continue
            close = difflib.get_close_matches(key.lower(), known, n=1, cutoff=0.75)
            if close:
                raise self.error(key, f"unknown. Did you mean '{close[0]}'?")

    def _node(self, key: str, example: str) -> yaml.Node:
        if key not in self._nodes:
            raise self.error(key, f"missing; add '{key}: {example}'")
        return self._nodes[key]

    def text(self, key: str, *, example: str) -> str:
        """A non-empty text."""
        node = self._node(key, example)
        if not isinstance(node, yaml.ScalarNode) or not node.value.strip():
            raise self.error(key, f"expected a text, got none; write e.g. '{key}: {example}'")
        return str(node.value)

    def choice(self, key: str, allowed: Sequence[str]) -> str:
        """One of the allowed words."""
        word = self.text(key, example=allowed[0])
        if word not in allowed:
            raise self.error(
                key,
                f"unknown value {shown(word)}.{did_you_mean(word, allowed)}"
                f" Known: {', '.join(allowed)}",
            )
        return word

    def words(self, key: str, allowed: Sequence[str]) -> tuple[str, ...]:
        """One of the allowed words, or a list of some."""
        node = self._node(key, allowed[0])
        items = node.value if isinstance(node, yaml.SequenceNode) else [node]
        words = [item.value if isinstance(item, yaml.ScalarNode) else "..." for item in items]
        for word in words:
            if word not in allowed:
                raise self.error(
                    key,
                    f"unknown value {shown(word)}.{did_you_mean(word, allowed)}"
                    f" Known: {', '.join(allowed)}",
                )
        if not words:
            raise self.error(key, f"expected some of {', '.join(allowed)}, got an empty list")
        return tuple(dict.fromkeys(words))

    def number(
        self,
        key: str,
        *,
        example: str,
        above: float = -math.inf,
        low: float = -math.inf,
        high: float = math.inf,
    ) -> float:
        """A finite number in ``(above, inf)`` and ``[low, high]``."""
        value = self._float(key, self._node(key, example), example)
        if value <= above:
            raise self.error(key, f"expected more than {above:g}, got {value:g}; e.g. {example}")
        if not low <= value <= high:
            raise self.error(
                key, f"expected {low:g} to {high:g}, got {value:g}; write e.g. '{key}: {example}'"
            )
        return value

    def integer(self, key: str, *, example: str, low: int, high: int) -> int:
        """A whole number in ``[low, high]``."""
        value = self.number(key, example=example, low=low, high=high)
        if value != int(value):
            raise self.error(key, f"expected a whole number, got {value:g}; e.g. {example}")
        return int(value)

    def flag(self, key: str, *, example: str) -> bool:
        """0, 1 or any other integer, true or false (as Nav2 reads ``negate``)."""
        word = self.text(key, example=example).lower()
        if word in ("true", "yes", "on", "false", "no", "off"):
            return word in ("true", "yes", "on")
        try:
            return int(word) != 0
        except ValueError:
            raise self.error(key, f"expected 0, 1, true or false, got {shown(word)}") from None

    def scalars(self, key: str, *, example: str) -> list[str]:
        """One value, or a list of at least one, each as it is written."""
        node = self._node(key, example)
        items = node.value if isinstance(node, yaml.SequenceNode) else [node]
        if not items:
            raise self.error(key, f"expected at least one value, got an empty list; e.g. {example}")
        for item in items:
            if not isinstance(item, yaml.ScalarNode) or not item.value.strip():
                raise self.error(key, f"expected values such as {example}, got none or a mapping")
        return [str(item.value) for item in items]

    def numbers(self, key: str, count: int | None, *, example: str) -> list[float]:
        """A list of finite numbers; ``count`` of them, or any even number if None."""
        node = self._node(key, example)
        if not isinstance(node, yaml.SequenceNode):
            raise self.error(key, f"expected a list of numbers such as {example}")
        values = [self._float(key, item, example) for item in node.value]
        if (count is not None and len(values) != count) or (count is None and len(values) % 2):
            want = f"{count} numbers" if count is not None else "pairs of numbers"
            raise self.error(key, f"expected {want} such as {example}, got {len(values)} numbers")
        return values

    def section(self, key: str) -> Section:
        """A nested mapping."""
        node = self._node(key, "{...}")
        if not isinstance(node, yaml.MappingNode):
            raise self.error(key, f"expected 'key: value' lines below '{key}:'")
        return Section(node, self.file, path=f"{self.path}{key}.")

    def sections(self, key: str) -> list[Section]:
        """A list of nested mappings; an absent key is an empty list."""
        if key not in self._nodes:
            return []
        node = self._nodes[key]
        if not isinstance(node, yaml.SequenceNode) or not all(
            isinstance(item, yaml.MappingNode) for item in node.value
        ):
            raise self.error(key, "expected a list of mappings, each starting with '- '")
        return [
            Section(item, self.file, path=f"{self.path}{key}[{i}].")
            for i, item in enumerate(node.value)
        ]

    def _float(self, key: str, node: yaml.Node, example: str) -> float:
        written = node.value if isinstance(node, yaml.ScalarNode) else "a nested value"
        try:
            value = float(written)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.error(key, f"expected a number, got {shown(written)}; e.g. {example}")
        return value
