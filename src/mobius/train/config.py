"""Presets as plain values and back: what a run folder and a policy file say about themselves."""

from __future__ import annotations

import dataclasses
import json
import math
import types
import typing
from typing import Any

from mobius.control.bodies import body_of
from mobius.control.clock import Gait
from mobius.errors import InvalidInput
from mobius.train.presets import EnvConfig, Preset


def as_plain(preset: Preset) -> dict[str, Any]:
    """The preset as JSON values."""
    plain: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(preset), allow_nan=False))
    return plain


def gait_of(cfg: EnvConfig) -> Gait:
    """The gait that an environment trains: the body's, as high as the configuration says."""
    gait = body_of(cfg.body).gait
    return gait if cfg.lift is None else dataclasses.replace(gait, height=cfg.lift)


def gait_as_plain(cfg: EnvConfig) -> dict[str, Any]:
    """The gait as arguments of :class:`mobius.control.clock.Gait`, in JSON values.

    A policy with a clock goes with the gait it was trained with. Infinity, which JSON lacks, is
    left out: it is the default where it occurs.
    """
    gait = dataclasses.asdict(gait_of(cfg))
    finite = {k: v for k, v in gait.items() if not (isinstance(v, float) and math.isinf(v))}
    plain: dict[str, Any] = json.loads(json.dumps(finite, allow_nan=False))
    return plain


def preset_from(plain: dict[str, Any]) -> Preset:
    """The preset that :func:`as_plain` made ``plain`` of.

    Raises:
        InvalidInput: it is of another version.
    """
    preset: Preset = _build(Preset, plain, "preset")
    return preset


def _build(kind: Any, value: Any, where: str) -> Any:
    """``value`` as the type ``kind``: dataclasses, optional ones, tuples, the rest as it is."""
    if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
        if value is None:
            return None
        (kind,) = [k for k in typing.get_args(kind) if k is not type(None)]
    if dataclasses.is_dataclass(kind) and isinstance(kind, type):
        hints = typing.get_type_hints(kind)
        known = {f.name for f in dataclasses.fields(kind)}
        if not isinstance(value, dict) or value.keys() != known:
            other = sorted(known ^ set(value)) if isinstance(value, dict) else value
            raise InvalidInput(f"{where} was written by another version of mobius: {other} differ")
        return kind(**{k: _build(hints[k], v, f"{where}.{k}") for k, v in value.items()})
    if typing.get_origin(kind) is tuple:
        return tuple(value)
    return value
