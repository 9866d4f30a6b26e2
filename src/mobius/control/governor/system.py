"""A governed loop as a linear system, what its outputs may be, and what may disturb it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput

__all__ = ["Constraints", "Disturbance", "LinearSystem"]

Array = NDArray[np.float64]


def _matrix(owner: str, name: str, value: ArrayLike, shape: tuple[int, int]) -> Array:
    """A read-only matrix of this shape; -1 takes any length."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInput(f"{owner}.{name}: expected a matrix of numbers, got {value!r}") from None
    fits = array.ndim == 2 and all(w in (-1, g) for w, g in zip(shape, array.shape, strict=True))
    if not fits:
        want = " x ".join("any" if s < 0 else str(s) for s in shape)
        raise InvalidInput(f"{owner}.{name}: expected a matrix {want}, got shape {array.shape}")
    if not np.isfinite(array).all():
        raise InvalidInput(f"{owner}.{name}: expected finite numbers, got {array.tolist()}")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A stable closed loop that follows a reference v and is disturbed by w.

    ``x+ = A x + B v + E w``, ``y = C x + D v + F w``; n states, m references, p outputs,
    l disturbances. Left out, D is zero and nothing disturbs the loop.

    Raises:
        InvalidInput: A matrix has the wrong shape, is not finite, or A is not stable.
    """

    A: Array
    """(n, n)."""
    B: Array
    """(n, m)."""
    C: Array
    """(p, n)."""
    D: Array = None  # type: ignore[assignment]
    """(p, m)."""
    E: Array = None  # type: ignore[assignment]
    """(n, l)."""
    F: Array = None  # type: ignore[assignment]
    """(p, l)."""

    def __post_init__(self) -> None:
        A = _matrix("LinearSystem", "A", self.A, (-1, -1))
        n = len(A)
        if A.shape != (n, n):
            raise InvalidInput(f"LinearSystem.A: expected a square matrix, got shape {A.shape}")
        B = _matrix("LinearSystem", "B", self.B, (n, -1))
        C = _matrix("LinearSystem", "C", self.C, (-1, n))
        p, m = len(C), B.shape[1]
        D = _matrix("LinearSystem", "D", np.zeros((p, m)) if self.D is None else self.D, (p, m))
        wide = next((np.shape(e)[1] for e in (self.E, self.F) if np.ndim(e) == 2), 0)
        E = _matrix("LinearSystem", "E", np.zeros((n, wide)) if self.E is None else self.E,
                    (n, wide))  # fmt: skip
        F = _matrix("LinearSystem", "F", np.zeros((p, wide)) if self.F is None else self.F,
                    (p, wide))  # fmt: skip
        for name, value in zip("ABCDEF", (A, B, C, D, E, F), strict=True):
            object.__setattr__(self, name, value)
        if self.spectral_radius >= 1.0:
            raise InvalidInput(
                "LinearSystem.A: expected a stable loop (all eigenvalues inside the unit circle),"
                f" got spectral radius {self.spectral_radius:.6g}; lower the gains, raise the"
                " damping, or close the loop before you govern it"
            )

    @property
    def sizes(self) -> tuple[int, int, int, int]:
        """Numbers of states, references, outputs and disturbances."""
        return (*self.B.shape, len(self.C), self.E.shape[1])

    @property
    def spectral_radius(self) -> float:
        """Largest modulus of an eigenvalue of A."""
        return float(np.abs(np.linalg.eigvals(self.A)).max())

    @property
    def steady_state(self) -> Array:
        """(n, m) the state it comes to rest at, per unit of reference: (I - A)^-1 B."""
        rest = np.linalg.solve(np.eye(len(self.A)) - self.A, self.B)
        return rest.astype(float)

    def step(self, x: Array, v: Array, w: Array | None = None) -> Array:
        """The next state (..., n) from x (..., n), v (..., m) and w (..., l)."""
        after = x @ self.A.T + v @ self.B.T
        return after if w is None else after + w @ self.E.T

    def output(self, x: Array, v: Array, w: Array | None = None) -> Array:
        """The output (..., p)."""
        y = x @ self.C.T + v @ self.D.T
        return y if w is None else y + w @ self.F.T


@dataclass(frozen=True, eq=False)
class Constraints:
    """What outputs may be: ``H y <= h``, with zero strictly inside (h > 0).

    Raises:
        InvalidInput: Shapes do not fit, or zero is not strictly inside.
    """

    H: Array
    """(q, p)."""
    h: Array
    """(q,)."""

    def __post_init__(self) -> None:
        H = _matrix("Constraints", "H", self.H, (-1, -1))
        h = _matrix("Constraints", "h", np.reshape(self.h, (1, -1)), (1, len(H)))[0]
        if not len(H) or (h <= 0).any():
            raise InvalidInput(
                "Constraints: expected limits with zero strictly inside (h > 0), got h ="
                f" {h.tolist()}; measure outputs from a point that is allowed"
            )
        object.__setattr__(self, "H", H)
        object.__setattr__(self, "h", h)

    @classmethod
    def box(cls, low: ArrayLike, high: ArrayLike) -> Constraints:
        """``low <= y <= high``; infinite where there is no limit.

        Args:
            low: (p,) < 0.
            high: (p,) > 0.
        """
        low, high = np.atleast_1d(np.array(low, float)), np.atleast_1d(np.array(high, float))
        if low.shape != high.shape or low.ndim != 1:
            raise InvalidInput(
                f"Constraints.box: expected low and high of one length, got shapes {low.shape}"
                f" and {high.shape}"
            )
        if np.isnan(low).any() or np.isnan(high).any() or (low >= high).any():
            raise InvalidInput(
                f"Constraints.box: expected low < high, got {low.tolist()} and {high.tolist()}"
            )
        eye = np.eye(len(low))
        H, h = np.vstack([eye, -eye]), np.concatenate([high, -low])
        return cls(H[np.isfinite(h)], h[np.isfinite(h)])


@dataclass(frozen=True, eq=False)
class Disturbance:
    """A bounded set W that w is in at every step: the hull of vertices, or a box.

    Raises:
        InvalidInput: A bound is negative or not finite.
    """

    vertices: Array
    """(k, l) corners; a box has its half widths here and ``is_box`` set."""
    is_box: bool = field(default=False)

    def __post_init__(self) -> None:
        vertices = _matrix("Disturbance", "vertices", self.vertices, (-1, -1))
        object.__setattr__(self, "vertices", vertices)
        if self.is_box and ((vertices < 0).any() or len(vertices) != 1):
            raise InvalidInput(
                f"Disturbance.box: expected half widths >= 0, got {vertices.tolist()}"
            )

    @classmethod
    def box(cls, half: ArrayLike) -> Disturbance:
        """``|w_i| <= half_i``, half (l,)."""
        return cls(np.atleast_2d(np.array(half, dtype=float)), is_box=True)

    def support(self, rows: Array) -> Array:
        """Largest value over W of rows (..., l) times w, shape (...)."""
        if self.is_box:
            return np.abs(rows) @ self.vertices[0]
        return (rows @ self.vertices.T).max(axis=-1)
