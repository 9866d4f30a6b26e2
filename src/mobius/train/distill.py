"""From a policy with a gait clock to one without: the paper's own observation (Sec. IV-A2).

A teacher with a clock walks; a student that sees only the paper's 26 x 16 (38 x 16) numbers is
taught its actions while the student itself drives (DAgger). A clock that ran on its own would
drift away from the student's steps, and the teacher would then ask for actions that fit a
phase the student cannot see. So the clock follows the student: every touchdown of a foot
pulls the phase towards the one at which that foot should land.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from mobius.control.clock import GaitClock
from mobius.control.observation import History, Layout, build_frame, mirror_frame, mirror_joints
from mobius.control.policy import PolicyFile
from mobius.train.env import LocomotionEnv

Array = NDArray[np.float64]

PULL = 0.5
"""Share of the phase error that a touchdown takes away."""


def follow_feet(clock: GaitClock, touchdown: Array) -> None:
    """Pull phases (n,) towards those at which the feet that just landed (n, f) should land."""
    wanted = (clock.gait.swing[1] - np.array(clock.gait.offsets)) % 1.0
    error = (wanted - clock.phase[:, None] + 0.5) % 1.0 - 0.5
    landed = touchdown > 0
    count = landed.sum(axis=1)
    mean = (error * landed).sum(axis=1) / np.maximum(count, 1)
    clock.phase = np.where(clock.moving, (clock.phase + PULL * mean) % 1.0, clock.phase)


class Student(nn.Module):
    """Normalised observation to mean action: the paper's 128 x 4 network."""

    mean: torch.Tensor
    std: torch.Tensor

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(inputs))
        self.register_buffer("std", torch.ones(inputs))
        sizes = [inputs, 128, 128, 128, 128]
        layers: list[nn.Module] = []
        for m, n in itertools.pairwise(sizes):
            layers += [nn.Linear(m, n), nn.SiLU()]
        self.net = nn.Sequential(*layers, nn.Linear(128, outputs))

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        """(n, inputs) -> (n, outputs)."""
        return self.net((obs - self.mean) / self.std)


class Distiller:
    """One student, one teacher, n robots."""

    def __init__(self, env: LocomotionEnv, teacher: PolicyFile, *, seed: int = 0) -> None:
        torch.manual_seed(seed)
        self.env, self.teacher = env, teacher
        self.layout = Layout("paper", env.layout.actions, 16)
        self.history = History(self.layout, env.n)
        self.student = Student(self.layout.size, env.layout.actions)
        self.optimiser = torch.optim.Adam(self.student.parameters(), lr=1e-3)
        self.mirror = mirror_frame(self.layout, env.body), mirror_joints(env.body)
        self.rng = np.random.default_rng(seed)
        self.seen: list[Array] = []
        self.wanted: list[Array] = []

    def observe(self) -> Array:
        """(n, size) the student's view of the present."""
        env = self.env
        frame = build_frame(
            self.layout,
            env.body,
            **env.seen,
            yaw0=env.yaw0,
            default=env.default,
            action=env.filter.last,
            command=env.command,
        )
        return self.history.push(frame)

    def collect(self, steps: int, share: float) -> dict[str, float]:
        """Walk ``steps`` policy steps; the teacher acts for a ``share`` of the robots."""
        env, falls, error = self.env, 0.0, 0.0
        driven = self.rng.random(env.n) < share
        for _ in range(steps):
            obs = self.observe()
            label = self.teacher.session.run(None, {"obs": env.observation.astype(np.float32)})[0]
            with torch.no_grad():
                own = self.student(torch.from_numpy(obs.astype(np.float32))).numpy()
            self.seen.append(obs.astype(np.float32))
            self.wanted.append(label)
            action = np.where(driven[:, None], label, own).astype(float)
            action += self.rng.normal(0, 0.1, action.shape)
            before = env.air.copy()
            result = env.step(action)
            follow_feet(env.clock, (env.air == 0) & (before > 0.05))
            self.history.reset(result.done)
            falls += float(result.log["/falls_per_minute"]) / steps
            error += float(result.log["/error/linear"]) / steps
        return {"falls_per_minute": falls, "error": error}

    def learn(self, epochs: int, batch: int, keep: int) -> float:
        """Regress on the newest ``keep`` collected steps; the mean loss."""
        self.seen, self.wanted = self.seen[-keep:], self.wanted[-keep:]
        obs = torch.from_numpy(np.concatenate(self.seen))
        act = torch.from_numpy(np.concatenate(self.wanted))
        if float(self.student.std.min()) == 1.0:
            self.student.mean.copy_(obs.mean(0))
            self.student.std.copy_(obs.std(0).clamp(min=0.01))
        (o_index, o_sign), (a_index, a_sign) = self.mirror
        o_sign_t, a_sign_t = (torch.from_numpy(s.astype(np.float32)) for s in (o_sign, a_sign))
        total = 0.0
        batches = epochs * len(obs) // batch
        for _ in range(batches):
            pick = torch.from_numpy(self.rng.integers(0, len(obs), batch))
            x, y = obs[pick], act[pick]
            half = batch // 2  # the mirror image of one half
            x = torch.cat([x[:half], x[half:][:, o_index] * o_sign_t])
            y = torch.cat([y[:half], y[half:][:, a_index] * a_sign_t])
            loss = nn.functional.smooth_l1_loss(self.student(x), y)
            self.optimiser.zero_grad()
            loss.backward()
            self.optimiser.step()
            total += float(loss.detach()) / batches
        return total


def distill(
    env: LocomotionEnv,
    teacher: PolicyFile,
    *,
    rounds: int,
    seed: int = 0,
    progress: Callable[[dict[str, float]], None] | None = None,
) -> Student:
    """Teach a clock-free student for ``rounds`` of 24 steps of every robot."""
    d = Distiller(env, teacher, seed=seed)
    for i in range(rounds):
        figures = d.collect(24, share=max(0.0, 1.0 - i / (0.2 * rounds)))
        for group in d.optimiser.param_groups:
            group["lr"] = 1e-3 * (1.0 - 0.9 * i / rounds)
        figures["loss"] = d.learn(2, 2048, 240)
        if progress is not None:
            progress({"round": i + 1, **figures})
    return d.student
