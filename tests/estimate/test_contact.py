"""Forces come back from the torques and wrenches that carry them; probabilities stick."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.estimate.config import ContactConfig
from mobius.estimate.contact import GRIPPER_MASS, ContactDetector, TorqueForce
from mobius.estimate.limbs import LimbKinematics, LimbState
from mobius.model import LIMB_JOINTS, limb_geometry
from mobius.model.leg import ankle_jacobian
from mobius.model.robot import keyframe_joints
from mobius.types import LIMBS

STANCE = keyframe_joints("crawl")[0]
UP = (0j, 1.0)
DT = 1 / 150


def limb_state(limb: str, rates: tuple[float, float] = (0.0, 0.0)) -> LimbState:
    q = STANCE[LIMB_JOINTS[limb]]
    dq = np.zeros(len(q))
    dq[1:3] = rates
    return LimbKinematics(limb_geometry(limb))(q.tolist(), dq.tolist(), UP)


def holding_torque(limb: str, state: LimbState, force: float) -> list[float]:
    """What both cranks need to hold the limb at rest against ``force`` [N] from below."""
    weight, _ = TorqueForce(limb, 1.0)._weight_and_inertia(state, complex(-1.0, 0.0))
    return [w + force * d.real for w, d in zip(weight, state.contact_drive, strict=True)]


@pytest.mark.parametrize("limb", LIMBS)
@pytest.mark.parametrize("force", [0.0, 25.0, 50.0])
def test_at_rest_the_torques_give_the_force_back(limb, force):
    state = limb_state(limb)
    felt = TorqueForce(limb, 160.0).update(
        state, UP, (0.0, 0.0), holding_torque(limb, state, force), DT
    )
    assert felt == pytest.approx(force, abs=1e-9)


def test_a_leg_s_weight_is_what_its_masses_weigh():
    # the ankle servo (165 g) and foot (85 g) move with ankle and contact; half the shank
    # (60 g) with the ankle, its other half and half a crank (12.5 g) with pin E, half crank
    # and coupler (27.5 g) with pin B: sum m g dz/dq11, with dz/dq11 = -J[2, 1] where rigid
    limb, g = "left_leg", limb_geometry("left_leg")
    state = limb_state(limb)
    J = ankle_jacobian(g, STANCE[LIMB_JOINTS[limb]])
    pin = state.pins[0].real  # B moves down by this
    ankle = -J[2, 1]
    foot = 0.1 * ankle + 0.9 * state.contact_drive[0].real
    by_hand = -9.81 * (0.0275 * pin + 0.225 * ankle + 0.085 * foot)
    weight, _ = TorqueForce(limb, 1.0)._weight_and_inertia(state, complex(-1.0, 0.0))
    assert weight[0] == pytest.approx(by_hand, rel=1e-9)


def test_torque_spent_on_the_rotors_is_not_taken_for_ground():
    """A limb that swings with growing speed needs torque; the momentum observer knows why."""
    limb = "left_leg"
    state = limb_state(limb)
    weight, (m_aa, m_ab, m_bb) = TorqueForce(limb, 1.0)._weight_and_inertia(state, complex(-1, 0))
    M, acceleration = np.array([[m_aa, m_ab], [m_ab, m_bb]]), np.array([20.0, -15.0])
    tau = np.array(weight) + M @ acceleration
    observer, naive = TorqueForce(limb, 160.0), TorqueForce(limb, 160.0)
    for k in range(15):
        felt = observer.update(state, UP, (acceleration * k * DT).tolist(), tau.tolist(), DT)
        fooled = naive.update(state, UP, (0.0, 0.0), tau.tolist(), DT)
    assert abs(fooled) > 10.0
    assert abs(felt) < 0.1


def test_a_step_of_force_is_felt_within_two_hundredths_of_a_second():
    limb = "right_leg"
    state, observer = limb_state(limb), TorqueForce(limb, 160.0)
    observer.update(state, UP, (0.0, 0.0), holding_torque(limb, state, 0.0), DT)
    for _ in range(3):
        felt = observer.update(state, UP, (0.0, 0.0), holding_torque(limb, state, 30.0), DT)
    assert felt > 20.0


def detect(detector: ContactDetector, force: float, steps: int = 40) -> list[float]:
    """Probabilities after the four limbs carried ``force`` [N] each for a while."""
    states = [limb_state(name) for name in LIMBS]
    wrench = np.zeros((2, 6))
    for i in range(2):  # the grippers hang upright: their z is up
        wrench[i, 2] = GRIPPER_MASS * 9.81 - force
    for _ in range(steps):
        found = detector.update(
            states,
            UP,
            rates=[(0.0, 0.0)] * 4,
            torques=[holding_torque(n, s, force) for n, s in zip(LIMBS, states, strict=True)],
            wrench_S=wrench.tolist(),
            dt=DT,
        )
    return found


@pytest.mark.parametrize("use_wrench", [True, False])
def test_a_quarter_of_the_robot_is_contact_and_nothing_is_none(use_wrench):
    detector = ContactDetector(ContactConfig(use_wrench=use_wrench))
    assert min(detect(detector, 25.0)) > 0.99
    assert detector.force == pytest.approx([25.0] * 4, abs=0.1)
    assert max(detect(detector, 0.0)) < 0.01


def test_a_grippers_own_weight_on_the_sensor_is_no_contact():
    # 0.46 kg: wrist servo, sensor, palm and two fingers
    assert abs(GRIPPER_MASS - (0.11 + 0.10 + 0.19 + 2 * 0.03)) < 1e-9
    assert max(detect(ContactDetector(), 0.0)[:2]) < 0.01


def test_a_limb_on_the_edge_stays_what_it_was():
    config = ContactConfig()
    standing, swinging = ContactDetector(config), ContactDetector(config)
    detect(standing, 25.0)
    detect(swinging, 0.0)
    assert min(detect(standing, config.force)) > 0.5
    assert max(detect(swinging, config.force)) < 0.5


def test_probability_is_a_half_where_the_config_says():
    config = replace(ContactConfig(), hysteresis=0.0)
    assert detect(ContactDetector(config), config.force, steps=200) == pytest.approx(
        [0.5] * 4, abs=0.02
    )
