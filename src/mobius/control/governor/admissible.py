"""A polytope of states and held references, and how far a reference may move in it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import linprog

from mobius.errors import InvalidInput, MobiusError
from mobius.files import write_bytes_atomic

__all__ = ["AdmissibleSet"]

Array = NDArray[np.float64]

EDGE = 1e-10
"""Rows broken by less are on the edge, not outside (rows are scaled to 1)."""


@dataclass(frozen=True, eq=False)
class AdmissibleSet:
    """``G_x x + G_v v <= 1``: no limit is ever broken from x while v is held."""

    G_x: Array
    """(r, n)."""
    G_v: Array
    """(r, m)."""
    horizon: int
    """Steps after which no row can matter; proven."""
    last_step: int
    """Latest step that a row kept here looks at."""
    loss: float
    """This set is at most this share smaller than the maximal one with the same epsilon."""
    epsilon: float
    """Share of the limits that the steady state keeps free."""

    def __post_init__(self) -> None:
        for name in ("G_x", "G_v"):
            array = np.array(getattr(self, name), dtype=float)
            if array.ndim != 2 or len(array) != len(self.G_x) or not np.isfinite(array).all():
                raise InvalidInput(
                    f"AdmissibleSet.{name}: expected a finite matrix with one row per"
                    f" half-space, got shape {array.shape}"
                )
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Numbers of rows, states and references."""
        return (*self.G_x.shape, self.G_v.shape[1])

    def slack(self, x: ArrayLike, v: ArrayLike) -> Array:
        """Least slack (...) of all rows; negative outside.

        Args:
            x: (..., n).
            v: (..., m).
        """
        x, v = np.asarray(x, float), np.asarray(v, float)
        return (1.0 - x @ self.G_x.T - v @ self.G_v.T).min(axis=-1)

    def contains(self, x: ArrayLike, v: ArrayLike) -> NDArray[np.bool_]:
        """Whether (x, v) is in the set; shapes as in :meth:`slack`."""
        return self.slack(x, v) >= -EDGE

    def fraction(self, x: ArrayLike, v: ArrayLike, r: ArrayLike) -> Array:
        """The largest share kappa (...) of the way from v to r that stays in the set.

        1 where r itself is admissible, 0 where (x, v) is not in the set. Shapes as in
        :meth:`slack`, r like v.
        """
        x, v, r = (np.asarray(a, float) for a in (x, v, r))
        room = 1.0 - x @ self.G_x.T - v @ self.G_v.T
        return fraction_of(room, (r - v) @ self.G_v.T)

    def project(self, x: ArrayLike) -> Array:
        """The reference (m,) that keeps the most room from the state x (n,), by HiGHS.

        Raises:
            InvalidInput: No reference is admissible from there.
        """
        rows, _, m = self.sizes
        room = 1.0 - self.G_x @ np.asarray(x, float)
        done = linprog(
            np.append(np.zeros(m), -1.0),
            A_ub=np.hstack([self.G_v, np.ones((rows, 1))]),
            b_ub=room,
            bounds=[(None, None)] * m + [(None, 1.0)],
        )
        if done.status != 0 or done.x[-1] < -EDGE:
            raise InvalidInput(
                f"no reference is admissible from the state {np.asarray(x).tolist()};"
                " bring the loop to rest inside its limits first"
            )
        return np.array(done.x[:m])

    def steady_range(self, direction: ArrayLike) -> float:
        """How far v may go along ``direction`` (m,), from rest there, times its length.

        Only the rows of the steady state (those without x) and of rest enter: the largest s
        such that s * direction can be held forever from some state.
        """
        rows, n, _ = self.sizes
        d = np.asarray(direction, float)
        A = np.hstack([self.G_x, self.G_v @ d[:, None]])
        done = linprog(np.append(np.zeros(n), -1.0), A_ub=A, b_ub=np.ones(rows),
                       bounds=(None, None))  # fmt: skip
        if done.status != 0:
            raise MobiusError(f"the range along {d.tolist()} is not bounded: {done.message}")
        return float(-done.fun)

    def as_json(self) -> dict[str, Any]:
        """Sizes and how it was determined; the rows are in the .npz file."""
        rows, n, m = self.sizes
        return {"rows": rows, "states": n, "references": m, "horizon_steps": self.horizon,
                "last_step": self.last_step, "loss": self.loss,
                "epsilon": self.epsilon}  # fmt: skip

    def save(self, path: str | Path) -> None:
        """Write the set as ``.npz``, whole or not at all."""
        import io

        out = io.BytesIO()
        kept: dict[str, Any] = {k: getattr(self, k) for k in self.__dataclass_fields__}
        np.savez(out, **kept)
        write_bytes_atomic(path, out.getvalue())

    @classmethod
    def load(cls, path: str | Path) -> AdmissibleSet:
        """Read what :meth:`save` wrote.

        Raises:
            InvalidInput: The file is not one of those.
        """
        try:
            with np.load(path) as kept:
                values = {k: kept[k] for k in cls.__dataclass_fields__}
        except (OSError, EOFError, BadZipFile, KeyError, ValueError, TypeError) as error:
            raise InvalidInput(f"{path}: expected a saved admissible set ({error})") from None
        return cls(
            values["G_x"],
            values["G_v"],
            horizon=int(values["horizon"]),
            last_step=int(values["last_step"]),
            loss=float(values["loss"]),
            epsilon=float(values["epsilon"]),
        )


def fraction_of(
    room: Array, toward: Array, *, least: Array | None = None, work: Array | None = None
) -> Array:
    """The share kappa from the room (..., r) of the rows and how much of it a whole step takes.

    ``min(1, min_i room_i / toward_i)`` over rows that the step approaches; 0 where room < 0.

    Args:
        room: (..., r).
        toward: (..., r).
        least: (...) the least room, where it is known.
        work: (..., r) to be written over; a new array if left out.
    """
    least = room.min(axis=-1) if least is None else least
    work = np.maximum(room, 1e-12, out=work)
    steepest = np.divide(toward, work, out=work).max(axis=-1)
    kappa = np.asarray(1.0 / np.maximum(steepest, 1.0))
    kappa[least < -EDGE] = 0.0
    return kappa
