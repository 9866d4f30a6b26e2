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

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.geometry import quat_to_mat, skew

Array = NDArray[np.float64]

PHI, VEL, POS = slice(0, 3), slice(3, 6), slice(6, 9)
GYRO, ACCEL, CAMERA = slice(9, 12), slice(12, 15), slice(15, 18)
YAW = 18
SIZE = 19
GRAVITY = np.array([0.0, 0.0, -9.81])


@dataclass(frozen=True)
class FilterNoise:
    """How much the filter trusts its devices and its start. Densities are per root hertz."""

    gyro: float = 4e-4
    """[rad/s/sqrt(Hz)], with the error of integrating at 300 Hz."""
    accel: float = 0.04
    """[m/s^2/sqrt(Hz)]; foot strikes shorter than a sample count for more than the chip."""
    gyro_bias: float = 5e-5
    """Random walk [rad/s/sqrt(s)]."""
    accel_bias: float = 1e-3
    """Random walk [m/s^2/sqrt(s)]."""
    camera_walk: float = 0.01
    """Drift of the camera's position per root metre travelled [m/sqrt(m)]."""
    camera_yaw_walk: float = 0.002
    """Drift of the camera's heading per root metre travelled [rad/sqrt(m)]."""
    start_tilt: float = 0.02
    """[rad]."""
    start_yaw: float = 0.005
    """[rad]."""
    start_position: float = 0.005
    """[m]."""
    start_velocity: float = 0.05
    """[m/s]."""
    start_gyro_bias: float = 0.005
    """[rad/s]."""
    start_accel_bias: float = 0.05
    """[m/s^2]."""


def exp_parts(phi: Array) -> tuple[Array, Array]:
    """exp(phi) in SO(3) and its left Jacobian, both (3, 3), for phi (3,) [rad]."""
    angle2 = float(phi @ phi)
    if angle2 < 1e-4:  # series to the order of double precision at 0.01 rad
        a, b, c = 1 - angle2 / 6, 0.5 - angle2 / 24, 1 / 6 - angle2 / 120
    else:
        angle = np.sqrt(angle2)
        a, b = np.sin(angle) / angle, (1 - np.cos(angle)) / angle2
        c = (1 - a) / angle2
    K = skew(phi)
    K2 = K @ K
    eye = np.eye(3)
    return eye + a * K + b * K2, eye + b * K + c * K2


class InvariantFilter:
    """The filter; what is measured and when is decided by :class:`mobius.estimate.Estimator`.

    Attributes:
        R: (3, 3) R_OB.
        v: (3,) trunk velocity in O [m/s].
        p: (3,) p_OB [m].
        gyro_bias: (3,) [rad/s].
        accel_bias: (3,) [m/s^2].
        camera: (3,) where the camera believes the trunk, in O [m].
        camera_yaw: Heading of the camera's frame in O [rad].
        P: (19, 19) covariance of (phi, rho_v, rho_p, b_g, b_a, c, psi).
    """

    def __init__(self, p_OB: ArrayLike, q_OB: ArrayLike, noise: FilterNoise | None = None) -> None:
        """Start at rest at a known pose: p_OB (3,) [m], q_OB (4,) wxyz."""
        n = self.noise = noise or FilterNoise()
        self.R: Array = quat_to_mat(q_OB)
        self.v, self.p = np.zeros(3), np.array(p_OB, dtype=float)
        self.gyro_bias, self.accel_bias = np.zeros(3), np.zeros(3)
        self.camera, self.camera_yaw = self.p.copy(), 0.0
        tilt, yaw = n.start_tilt**2, n.start_yaw**2
        blocks = (n.start_velocity, n.start_position, n.start_gyro_bias, n.start_accel_bias)
        diagonal = [tilt, tilt, yaw, *np.repeat(np.square(blocks), 3), 0.0, 0.0, 0.0, 0.0]
        self.P = np.diag(np.array(diagonal))
        # rho_p of a known place: p - p_hat = phi x p_hat + rho_p must stay small
        lever = np.eye(SIZE)
        lever[POS, PHI] = skew(self.p)
        self.P = lever @ self.P @ lever.T
        self._F = np.eye(SIZE)
        self._walk = np.zeros(SIZE)
        self._walk[GYRO], self._walk[ACCEL] = n.gyro_bias**2, n.accel_bias**2
        self._density = np.repeat(np.square([n.gyro, n.accel]), 3)

    # -- prediction ----------------------------------------------------------------------

    def predict(self, gyro: Array, accel: Array, dt: float) -> None:
        """Advance by ``dt`` [s] with the IMU readings (3,) that end the interval."""
        w, a = gyro - self.gyro_bias, accel - self.accel_bias
        F, R = self._F, self.R
        F[VEL, PHI] = skew(GRAVITY * dt)
        F[POS, VEL] = np.eye(3) * dt
        Rdt = R * dt
        F[PHI, GYRO] = F[VEL, ACCEL] = -Rdt
        both = skew(np.array([self.v, self.p])) @ Rdt
        F[VEL, GYRO], F[POS, GYRO] = -both[0], -both[1]
        noise = F[:9, 9:15]  # bias errors and noise enter alike
        P = F @ self.P @ F.T
        P[:9, :9] += (noise * (self._density / dt)) @ noise.T
        P.ravel()[:: SIZE + 1] += self._walk * dt
        self.P = P
        turn, _ = exp_parts(w * dt)
        self.R = R @ turn
        push = self.R @ a + GRAVITY
        self.p = self.p + self.v * dt + push * (0.5 * dt * dt)
        self.v = self.v + push * dt

    def orthonormalise(self) -> None:
        """One Newton step that takes R back to a rotation."""
        self.R = 1.5 * self.R - 0.5 * self.R @ (self.R.T @ self.R)

    # -- correction ----------------------------------------------------------------------

    def correct(
        self, H: Array, residual: Array, N: Array, *, gate: float = np.inf
    ) -> float:
        """Kalman update; returns the squared Mahalanobis distance of the residual.

        Args:
            H: (m, 19) residual = H error + noise.
            residual: (m,) measured minus predicted.
            N: (m, m) noise covariance.
            gate: Do nothing when the distance exceeds this.
        """
        PHt = self.P @ H.T
        S_inv = np.linalg.inv(H @ PHt + N)
        distance = float(residual @ S_inv @ residual)
        if distance <= gate:
            K = PHt @ S_inv
            P = self.P - K @ PHt.T
            self.P = 0.5 * (P + P.T)
            self._retract(K @ residual)
        return distance

    def _retract(self, error: Array) -> None:
        """X <- exp(xi) X; the rest is a vector space."""
        turn, J = exp_parts(error[PHI])
        self.R = turn @ self.R
        self.v = turn @ self.v + J @ error[VEL]
        self.p = turn @ self.p + J @ error[POS]
        self.gyro_bias = self.gyro_bias + error[GYRO]
        self.accel_bias = self.accel_bias + error[ACCEL]
        self.camera = self.camera + error[CAMERA]
        self.camera_yaw += float(error[YAW])

    def correct_velocity(self, v_B: Array, variance: float) -> float:
        """The trunk moves at v_B (3,) [m/s], trunk frame; isotropic variance [m^2/s^2]."""
        return self.correct(_H_VELOCITY, self.R @ v_B - self.v, variance * np.eye(3))

    def correct_height(self, point_B: Array, variance: float) -> float:
        """The point_B (3,) [m] of the trunk frame is at height zero; variance [m^2]."""
        lever = self.R @ point_B
        point = self.p + lever
        H = np.zeros((1, SIZE))
        H[0, 0], H[0, 1], H[0, 8] = point[1], -point[0], 1.0  # (phi x point)_z + rho_p,z
        return self.correct(H, np.array([-point[2]]), np.array([[variance]]))

    def correct_rest(self, gyro: Array, variance: float) -> float:
        """The trunk does not turn while the gyro says (3,) [rad/s]; variance [rad^2/s^2]."""
        return self.correct(_H_GYRO, gyro - self.gyro_bias, variance * np.eye(3))

    # -- camera --------------------------------------------------------------------------

    def _past(self, w_B: Array, latency: float) -> tuple[Array, Array, Array]:
        """Rotation and position ``latency`` [s] ago, and d(position)/d(error) (3, 19)."""
        past = self.p - latency * self.v
        back, _ = exp_parts(w_B * -latency)
        H = np.zeros((3, SIZE))
        H[:, PHI] = -skew(past)
        H[:, VEL] = -latency * np.eye(3)
        H[:, POS] = np.eye(3)
        return self.R @ back, past, H

    def move_camera(self, step_V: Array) -> None:
        """The camera says the trunk moved by step_V (3,) [m] in its own frame V."""
        c, s = np.cos(self.camera_yaw), np.sin(self.camera_yaw)
        dx, dy = c * step_V[0] - s * step_V[1], s * step_V[0] + c * step_V[1]
        self.camera = self.camera + [dx, dy, step_V[2]]
        F = np.eye(SIZE)
        F[15, YAW], F[16, YAW] = -dy, dx
        self.P = F @ self.P @ F.T
        way = float(np.sqrt(step_V @ step_V))
        walk, yaw_walk = self.noise.camera_walk**2, self.noise.camera_yaw_walk**2
        self.P[[15, 16, 17, 18], [15, 16, 17, 18]] += [way * walk] * 3 + [way * yaw_walk]

    def anchor_camera(
        self, w_B: Array, latency: float, *, position_variance: float, yaw: float | None = None,
        yaw_variance: float
    ) -> None:
        """Put the camera's track back on the trunk's.

        Args:
            w_B: (3,) trunk angular velocity [rad/s].
            latency: Age of the camera's pose [s].
            position_variance: Of the pose that anchors [m^2].
            yaw: Heading of the camera's frame in O where it is not known yet [rad].
            yaw_variance: Of that heading, or what its uncertainty grows by [rad^2].
        """
        _, past, H = self._past(w_B, latency)
        self.camera = past
        rows = H @ self.P
        self.P[CAMERA, :], self.P[:, CAMERA] = rows, rows.T
        self.P[CAMERA, CAMERA] = rows @ H.T + position_variance * np.eye(3)
        if yaw is not None:
            self.camera_yaw = yaw
            self.P[YAW, :] = self.P[2, :]
            self.P[:, YAW] = self.P[:, 2]
            self.P[YAW, YAW] = self.P[2, 2]
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
        R_past, past, H_position = self._past(w_B, latency)
        c, s = np.cos(self.camera_yaw), np.sin(self.camera_yaw)
        E = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ R_VB @ R_past.T
        H = np.zeros((6, SIZE))
        H[:3, PHI] = np.eye(3)
        H[2, YAW] = -1.0
        H[3:] = H_position
        H[3:, CAMERA] = -np.eye(3)
        residual = np.empty(6)
        residual[:3] = _small_log(E)
        residual[3:] = self.camera - past
        return self.correct(H, residual, N, gate=gate)

    # -- what it believes ----------------------------------------------------------------

    def covariance(self) -> Array:
        """(12, 12) of rotation vector (axes of O), p_OB, w_B and v_B; gyro noise not included."""
        M = np.zeros((12, SIZE))
        M[0:3, PHI] = np.eye(3)
        M[3:6, PHI], M[3:6, POS] = -skew(self.p), np.eye(3)
        M[6:9, GYRO] = -np.eye(3)
        M[9:12, VEL] = self.R.T
        return M @ self.P @ M.T


def _small_log(R: Array) -> Array:
    """Rotation vector (3,) of a rotation below a quarter turn, to third order of the sine."""
    sine = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    s2 = float(sine @ sine)
    return sine * (1 + s2 / 6)


_H_VELOCITY = np.eye(SIZE)[VEL]
_H_GYRO = np.eye(SIZE)[GYRO]
