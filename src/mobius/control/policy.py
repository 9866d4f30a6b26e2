"""A learned locomotion policy in the loop: belief and encoders in, servo targets out."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime as ort
from numpy.typing import NDArray

from mobius.control.action import POLICY_DT, ActionFilter
from mobius.control.bodies import Body, body_of
from mobius.control.clock import Gait, GaitClock
from mobius.control.observation import History, Layout, build_frame
from mobius.errors import PolicyError
from mobius.geometry import heading_yaw, rotate
from mobius.model.build import joint_ranges
from mobius.model.reach import longest_step
from mobius.model.robot import keyframe_joints
from mobius.types import NUM_JOINTS, JointCommand, ModeCommand, SensorFrame, StateEstimate

Array = NDArray[np.float64]


APART = 0.03
"""A policy whose feet stand this far from those of its body's keyframe [m] stands apart."""


@dataclass(frozen=True, eq=False)
class PolicyFile:
    """An ONNX policy and what its metadata says."""

    session: ort.InferenceSession
    body: Body
    gait: Gait
    layout: Layout
    default: Array
    """(22,) Theta_default: servo targets of the stance [rad]."""
    scale: float
    filter_length: int
    metadata: dict[str, Any]

    @property
    def apart(self) -> bool:
        """Whether its stance is another than its body's keyframe, where motions begin."""
        return longest_step(self.default, keyframe_joints(self.body.keyframe)[1]) > APART


def shipped_policy(body: str, *, rough: bool = False) -> Path:
    """Path of the policy that comes with the package: for flat floors, or for ``rough`` ground."""
    name = f"{body}_rough" if rough else body
    return Path(str(resources.files("mobius.control") / "policies" / f"{name}.onnx"))


def load_policy(path: Path | str) -> PolicyFile:
    """Read an ONNX policy. Raises :class:`PolicyError` when it does not fit this robot."""
    path = Path(path)
    if not path.is_file():
        raise PolicyError(f"{path}: no such policy file; make one with mobius train")
    options = ort.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 3
    try:
        session = ort.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's errors share no base but Exception
        raise PolicyError(f"{path}: not an ONNX model ({type(error).__name__})") from None
    try:
        meta = json.loads(session.get_modelmeta().custom_metadata_map["mobius"])
        body = body_of(meta["body"])
        layout = Layout(meta["frame"], len(body.joints), int(meta["history"]), bool(meta["clock"]))
        default = np.array(meta["default"], dtype=float)
        gait = Gait(**meta["gait"]) if "gait" in meta else body.gait
        joints, scale, length = tuple(meta["joints"]), meta["scale"], meta["filter_length"]
    except (LookupError, ValueError, TypeError) as error:
        raise PolicyError(f"{path}: its metadata is not mobius' ({error!r})") from None
    if joints != body.joints:
        raise PolicyError(f"{path}: its joints {list(joints)} are not {list(body.joints)}")
    width = session.get_inputs()[0].shape[-1]
    if width != layout.size or default.shape != (NUM_JOINTS,):
        raise PolicyError(
            f"{path}: expected {layout.size} observations and {NUM_JOINTS} default angles,"
            f" got {width} and {default.shape}"
        )
    return PolicyFile(session, body, gait, layout, default, float(scale), int(length), meta)


class PolicyController:
    """Runs a policy at 60 Hz; the same frames, history and filter as in training."""

    def __init__(self, policy: PolicyFile) -> None:
        self.policy = policy
        self.apart = policy.apart
        body = policy.body
        self._index = body.index
        ranges = joint_ranges()
        low, high = np.array([ranges[j] for j in body.joints]).T
        self._default = policy.default[self._index]
        self._filter = ActionFilter(
            self._default, low, high, scale=policy.scale, length=policy.filter_length
        )
        self._history = History(policy.layout, 1)
        self._clock = GaitClock(policy.gait)
        self._yaw0 = np.zeros(1)
        self.observation = np.zeros(policy.layout.size)
        """The newest observation, for logs and tests."""
        self.reset()

    def reset(self) -> None:
        """Forget history and past actions; the next observation starts anew."""
        self._filter.reset()
        self._history.reset()
        self._clock.reset()
        self._started = False

    def act(self, command: ModeCommand, belief: StateEstimate, frame: SensorFrame) -> JointCommand:
        """Servo targets of all 22 joints for one policy step."""
        if not self._started:
            self._yaw0[0] = heading_yaw(self.policy.body.heading, belief.q_OB)
            self._started = True
        speed = float(np.hypot(*rotate(belief.q_OB, belief.v_B)[:2]))
        self._clock.advance(command.twist_H[None], POLICY_DT, speed)
        observation = self._history.push(
            build_frame(
                self.policy.layout,
                self.policy.body,
                q_OB=belief.q_OB[None],
                v_B=belief.v_B[None],
                w_B=belief.w_B[None],
                yaw0=self._yaw0,
                joints=frame.q[self._index][None],
                default=self._default,
                action=self._filter.last,
                command=command.twist_H[None],
                clock=self._clock.observe(),
            )
        )
        self.observation = observation[0]
        action = self.policy.session.run(None, {"obs": observation.astype(np.float32)})[0]
        q = self.policy.default.copy()
        q[self._index] = self._filter.push(action.astype(float))[0]
        return JointCommand(q=q, stamp=frame.stamp)
