"""A nested tree of arrays and plain values as one safetensors file: no pickle, whole or absent.

Arrays become tensors named by their path in the tree (``env/sim/state``); everything else
(numbers, strings, random states, the shape of the tree) is JSON in the file's metadata.
Anything that reads safetensors reads these files; nothing in them can run code.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import safetensors
import safetensors.numpy

from mobius.errors import InvalidInput
from mobius.files import write_bytes_atomic

FORMAT = "mobius tree 1"
_ARRAY = "$array"


def write_tree(path: Path, tree: Mapping[str, Any]) -> None:
    """Replace ``path`` by ``tree``, atomically.

    Args:
        path: File to write; folders that lack are made.
        tree: Dictionaries with string keys, lists, tuples (read back as lists), arrays, torch
            tensors on the CPU (read back as arrays), numbers, strings, None.

    Raises:
        InvalidInput: the tree holds something else, or a plain number that is not finite.
    """
    arrays: dict[str, np.ndarray[Any, Any]] = {}
    plain = _split(tree, "", arrays)
    try:
        text = json.dumps(plain, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{path}: cannot store this tree: {error}") from None
    data = safetensors.numpy.save(arrays, {"format": FORMAT, "tree": text})
    write_bytes_atomic(path, data)


def read_tree(path: Path) -> dict[str, Any]:
    """The tree in ``path``, with arrays as numpy arrays.

    Raises:
        InvalidInput: there is no such file, it is cut off, or it is not one of ours.
    """
    if not path.is_file():
        raise InvalidInput(f"{path}: no such file")
    try:
        with safetensors.safe_open(str(path), framework="numpy") as file:
            meta = file.metadata() or {}
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except (safetensors.SafetensorError, OSError) as error:
        raise InvalidInput(f"{path}: not a whole safetensors file ({error})") from None
    if meta.get("format") != FORMAT:
        raise InvalidInput(
            f"{path}: expected a file of the format '{FORMAT}', got '{meta.get('format')}'"
        )
    tree: dict[str, Any] = _join(json.loads(meta["tree"]), arrays)
    return tree


def _split(node: Any, name: str, arrays: dict[str, np.ndarray[Any, Any]]) -> Any:
    """``node`` with its arrays moved to ``arrays`` and references in their place."""
    if isinstance(node, Mapping):
        for key in node:
            if not isinstance(key, str) or key == _ARRAY:
                raise InvalidInput(f"'{name}': expected string keys, got {key!r}")
        return {k: _split(v, f"{name}/{k}" if name else k, arrays) for k, v in node.items()}
    if isinstance(node, list | tuple):
        return [_split(v, f"{name}/{i}", arrays) for i, v in enumerate(node)]
    if hasattr(node, "detach"):  # a torch tensor; this file does not need torch for it
        node = node.detach().numpy()
    if isinstance(node, np.generic):
        return node.item()
    if isinstance(node, np.ndarray):
        if name in arrays:
            raise InvalidInput(f"two arrays are called '{name}'")
        arrays[name] = np.array(node, order="C")
        return {_ARRAY: name}
    return node


def _join(node: Any, arrays: Mapping[str, np.ndarray[Any, Any]]) -> Any:
    if isinstance(node, dict):
        if node.keys() == {_ARRAY}:
            return arrays[node[_ARRAY]]
        return {k: _join(v, arrays) for k, v in node.items()}
    if isinstance(node, list):
        return [_join(v, arrays) for v in node]
    return node
