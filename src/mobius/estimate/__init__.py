"""What the robot believes of itself: a contact-aided right-invariant Kalman filter."""

from mobius.estimate.config import ContactConfig as ContactConfig
from mobius.estimate.config import EstimatorConfig as EstimatorConfig
from mobius.estimate.config import FilterNoise as FilterNoise
from mobius.estimate.estimator import Estimator as Estimator
from mobius.estimate.iekf import InvariantFilter as InvariantFilter
