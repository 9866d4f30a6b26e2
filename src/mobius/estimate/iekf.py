r"""Right-invariant extended Kalman filter on SE_2(3), IMU biases and the camera's own track.

The state is ``X = (R_OB, v_O, p_O)``, the biases ``b_g, b_a`` of the IMU and ``c``, the
place where the drifting camera believes the trunk to be, carried into the odom frame. The
error is right-invariant (Hartley et al., IJRR 2020): ``X = exp(xi) X_hat`` with
``xi = (phi, rho_v, rho_p)``, so that

    R = exp(phi) R_hat,   v = exp(phi) v_hat + J rho_v,   p = exp(phi) p_hat + J rho_p

and, with true rates ``w = gyro - b_g - n`` and ``a = accel - b_a - n``,

    d phi   = -R b_g
    d rho_v = g x phi - R b_a - v x R b_g
    d rho_p = rho_v - p x R b_g                     (b: errors of the biases)

does not depend on the attitude error: yaw and horizontal place stay unobservable to leg
odometry by construction, and a velocity measured in the trunk frame is linear in rho_v.

The camera is a second odometer. Between two of its poses ``c`` moves by what the camera
says, turned by its yaw offset ``psi``, and gathers the camera's drift; each pose then says
that ``c`` and the trunk (a latency ago) coincide. After a gap or a jump ``c`` is put back on
the trunk with a covariance that says so (:meth:`InvariantFilter.anchor_camera`): a jump of
the camera is never a jump of the belief.
"""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.estimate.config import FilterNoise
from mobius.estimate.rotations import exp_so3, left_jacobian, small_log
from mobius.geometry import quat_to_mat, skew

Array = NDArray[np.float64]

PHI, VEL, POS = slice(0, 3), slice(3, 6), slice(6, 9)
GYRO, ACCEL, CAMERA = slice(9, 12), slice(12, 15), slice(15, 18)
YAW = 18
SIZE = 19
GRAVITY = np.array([0.0, 0.0, -9.81])
_GRAVITY_CROSS = skew(GRAVITY)
_EYE3 = np.eye(3)


class InvariantFilter:
    """The filter; what is measured and when is decided by :class:`mobius.estimate.Estimator`.

    Attributes:
        R: (3, 3) R_OB.
        v: (3,) trunk velocity in O [m/s].
        p: (3,) p_OB [m].
        rest: (10,) gyro bias [rad/s], accelerometer bias [m/s^2], where the camera believes
            the trunk in O [m], heading of the camera's frame in O [rad].
        P: (19, 19) covariance of (phi, rho_v, rho_p, b_g, b_a, c, psi).
    """

    def __init__(self, p_OB: ArrayLike, q_OB: ArrayLike, noise: FilterNoise | None = None) -> None:
        """Start at rest at a known pose: p_OB (3,) [m], q_OB (4,) wxyz."""
        n = self.noise = noise or FilterNoise()
        self.R: Array = quat_to_mat(np.asarray(q_OB, dtype=float))
        self.v, self.p = np.zeros(3), np.array(p_OB, dtype=float)
        self.rest = np.array([0.0] * 6 + [*self.p, 0.0])
        tilt, yaw = n.start_tilt**2, n.start_yaw**2
        blocks = (n.start_velocity, n.start_position, n.start_gyro_bias, n.start_accel_bias)
        diagonal = [tilt, tilt, yaw, *np.repeat(np.square(blocks), 3), 0.0, 0.0, 0.0, 0.0]
        # p - p_hat = phi x p_hat + rho_p is what start_position speaks of
        lever = np.eye(SIZE)
        lever[POS, PHI] = skew(self.p)
        self.P: Array = lever @ np.diag(diagonal) @ lever.T
        self._F, self._skew, self._spread_due = np.eye(SIZE), np.zeros((2, 3, 3)), 0.0
        walk = [n.gyro_bias**2] * 3 + [n.accel_bias**2] * 3
        self._walk = np.array([0.0] * 9 + walk + [0.0] * 4)
        self._density = np.repeat(np.square([n.gyro, n.accel]), 3)
        self._H_legs = np.zeros((4, SIZE))
        self._H_legs[:3, VEL], self._H_legs[3, 8] = _EYE3, 1.0
        self._to_belief = np.zeros((12, SIZE))
        self._to_belief[0:3, PHI] = self._to_belief[3:6, POS] = _EYE3
        self._to_belief[6:9, GYRO] = -_EYE3

    @property
    def gyro_bias(self) -> Array:
        """(3,) [rad/s]."""
        return self.rest[0:3]

    @property
    def accel_bias(self) -> Array:
        """(3,) [m/s^2]."""
        return self.rest[3:6]

    @property
    def camera(self) -> Array:
        """(3,) where the camera believes the trunk to be, in O [m]."""
        return self.rest[6:9]

    # -- prediction ----------------------------------------------------------------------

    def predict(self, gyro: Array, accel: Array, dt: float) -> None:
        """Advance by ``dt`` [s] with the IMU readings (3,) that end the interval.

        The covariance follows when the next correction needs it.
        """
        self._spread_due += dt
        self.R = self.R @ exp_so3(*((gyro - self.rest[0:3]) * dt).tolist())
        push = (self.R @ (accel - self.rest[3:6]) + GRAVITY) * dt
        self.p = self.p + (self.v + 0.5 * push) * dt
        self.v = self.v + push

    def spread(self) -> None:
        """Bring the covariance up to the state: the time since it was last is one step."""
        dt, self._spread_due = self._spread_due, 0.0
        if dt == 0.0:
            return
        F = self._F
        F[VEL, PHI], F[POS, VEL] = _GRAVITY_CROSS * dt, _EYE3 * dt
        Rdt = self.R * -dt
        F[PHI, GYRO] = F[VEL, ACCEL] = Rdt
        F[3:9, GYRO] = (self._cross_matrices() @ Rdt).reshape(6, 3)
        noise = F[:9, 9:15]  # errors of the biases and noise enter alike
        P = F @ self.P @ F.T
        P[:9, :9] += (noise * (self._density / dt)) @ noise.T
        P.ravel()[:: SIZE + 1] += self._walk * dt
        self.P = P

    def _cross_matrices(self) -> Array:
        """(2, 3, 3) cross-product matrices of v and p, in place."""
        out = self._skew
        for K, (x, y, z) in zip(out, (self.v.tolist(), self.p.tolist()), strict=True):
            K[0, 1], K[0, 2], K[1, 2] = -z, y, -x
            K[1, 0], K[2, 0], K[2, 1] = z, -y, x
        return out

    def clean(self) -> None:
        """Take R back to a rotation and P to a symmetric matrix, against rounding."""
        self.R = 1.5 * self.R - 0.5 * self.R @ (self.R.T @ self.R)
        self.P = 0.5 * (self.P + self.P.T)

    # -- correction ----------------------------------------------------------------------

    def correct(self, H: Array, residual: Array, N: Array, *, gate: float = np.inf) -> float:
        """Kalman update; returns the squared Mahalanobis distance of the residual.

        Args:
            H: (m, 19) residual = H error + noise.
            residual: (m,) measured minus predicted.
            N: (m, m) noise covariance.
            gate: Do nothing when the distance exceeds this.
        """
        self.spread()
        PHt = self.P @ H.T
        S_inv = np.linalg.inv(H @ PHt + N)
        weighed = S_inv @ residual
        distance = float(residual @ weighed)
        if distance <= gate:
            self.P = self.P - PHt @ S_inv @ PHt.T
            self._retract(PHt @ weighed)
        return distance

    def _retract(self, error: Array) -> None:
        """X <- exp(xi) X; the rest is a vector space."""
        phi = error[PHI].tolist()
        turn, J = exp_so3(*phi), left_jacobian(*phi)
        self.R = turn @ self.R
        self.v = turn @ self.v + J @ error[VEL]
        self.p = turn @ self.p + J @ error[POS]
        self.rest = self.rest + error[9:]

    def correct_velocity(self, v_B: Array, variance: float) -> float:
        """The trunk moves at v_B (3,) [m/s], trunk frame; isotropic variance [m^2/s^2]."""
        return self.correct(_H_VELOCITY, self.R @ v_B - self.v, variance * _EYE3)

    def correct_height(self, point_B: Array, variance: float) -> float:
        """The point_B (3,) [m] of the trunk frame is at height zero; variance [m^2]."""
        lever = self.R @ point_B
        point = self.p + lever
        H = np.zeros((1, SIZE))
        H[0, 0], H[0, 1], H[0, 8] = point[1], -point[0], 1.0  # (phi x point)_z + rho_p,z
        return self.correct(H, np.array([-point[2]]), np.array([[variance]]))

    def correct_legs(
        self, v_B: Array, variance: float, point_B: Array, height_variance: float
    ) -> float:
        """Velocity and height at once, as :meth:`correct_velocity` and :meth:`correct_height`."""
        point = self.p + self.R @ point_B
        H, residual = self._H_legs, np.empty(4)
        H[3, 0], H[3, 1] = point[1], -point[0]
        residual[:3], residual[3] = self.R @ v_B - self.v, -point[2]
        return self.correct(H, residual, np.diag([variance, variance, variance, height_variance]))

    def correct_rest(self, gyro: Array, variance: float) -> float:
        """The trunk does not turn while the gyro says (3,) [rad/s]; variance [rad^2/s^2]."""
        return self.correct(_H_GYRO, gyro - self.rest[0:3], variance * _EYE3)

    def doubt_velocity(self, variance: float) -> None:
        """What the sources say contradicts the velocity: let them move it; [m^2/s^2]."""
        self.P[VEL, VEL] += variance * _EYE3

    def doubt_height(self, variance: float) -> None:
        """The floor was not heard for a while: let it move the height; [m^2]."""
        self.P[8, 8] += variance

    # -- camera --------------------------------------------------------------------------

    def _past(self, latency: float) -> tuple[Array, Array]:
        """Position ``latency`` [s] ago (3,) [m], and d(position)/d(error) (3, 19)."""
        past = self.p - latency * self.v
        H = np.zeros((3, SIZE))
        H[:, PHI] = -skew(past)
        H[:, VEL] = -latency * _EYE3
        H[:, POS] = _EYE3
        return past, H

    def move_camera(self, step_V: Array) -> None:
        """The camera says the trunk moved by step_V (3,) [m] in its own frame V."""
        self.spread()
        x, y, z = step_V.tolist()
        yaw = self.rest[9]
        c, s = cos(yaw), sin(yaw)
        dx, dy = c * x - s * y, s * x + c * y
        self.rest[6:9] += (dx, dy, z)
        P = self.P
        P[15] -= dy * P[YAW]  # c moves with the heading: F P F^T, F = 1 but for two entries
        P[16] += dx * P[YAW]
        P[:, 15] -= dy * P[:, YAW]
        P[:, 16] += dx * P[:, YAW]
        way = sqrt(x * x + y * y + z * z)
        walk = way * self.noise.camera_walk**2
        P.ravel()[15 * (SIZE + 1) :: SIZE + 1] += (
            walk,
            walk,
            walk,
            way * self.noise.camera_yaw_walk**2,
        )

    def anchor_camera(
        self,
        latency: float,
        *,
        position_variance: float,
        yaw_variance: float,
        yaw: float | None = None,
    ) -> None:
        """Put the camera's track back on the trunk's.

        Args:
            latency: Age of the camera's pose [s].
            position_variance: Of the pose that anchors [m^2].
            yaw_variance: Of the heading below, or what its uncertainty grows by [rad^2].
            yaw: Heading of the camera's frame in O where it is not known yet [rad].
        """
        self.spread()
        past, H = self._past(latency)
        rows = H @ self.P
        self.P[CAMERA, :], self.P[:, CAMERA] = rows, rows.T
        self.P[CAMERA, CAMERA] = rows @ H.T + position_variance * _EYE3
        self.rest[6:9] = past
        if yaw is not None:
            self.rest[9] = yaw
            self.P[YAW, :] = self.P[2, :]
            self.P[:, YAW] = self.P[:, 2]
        self.P[YAW, YAW] += yaw_variance

    def correct_camera(
        self, R_VB: Array, w_B: Array, latency: float, *, N: Array, gate: float
    ) -> float:
        """The camera's pose and the trunk's, a latency ago, are one.

        Args:
            R_VB: (3, 3) orientation in the camera's frame; its position is ``self.camera``.
            w_B: (3,) trunk angular velocity [rad/s].
            latency: Age of the pose [s].
            N: (6, 6) noise of rotation vector [rad] and position [m], axes of O.
            gate: Squared Mahalanobis distance beyond which the pose is not used.
        """
        past, H_position = self._past(latency)
        c, s = cos(self.rest[9]), sin(self.rest[9])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        H = np.zeros((6, SIZE))
        H[:3, PHI] = _EYE3
        H[2, YAW] = -1.0
        H[3:] = H_position
        H[3:, CAMERA] = -_EYE3
        residual = np.empty(6)
        # R_VB is of the past: R_now = R_VB exp(w latency)
        residual[:3] = small_log(turn @ R_VB @ exp_so3(*(w_B * latency).tolist()) @ self.R.T)
        residual[3:] = self.rest[6:9] - past
        return self.correct(H, residual, N, gate=gate)

    # -- what it believes ----------------------------------------------------------------

    def covariance(self) -> Array:
        """(12, 12) of rotation vector (axes of O), p_OB, w_B and v_B, as of the last spread."""
        M = self._to_belief
        M[3:6, PHI] = -self._cross_matrices()[1]
        M[9:12, VEL] = self.R.T
        cov: Array = M @ self.P @ M.T
        cov.ravel()[6 * 13 : 9 * 13 : 13] += self.noise.gyro_reading**2
        return cov


_H_VELOCITY = np.eye(SIZE)[VEL]
_H_GYRO = np.eye(SIZE)[GYRO]
