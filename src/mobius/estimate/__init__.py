"""What the robot believes of itself: a contact-aided right-invariant Kalman filter."""

from mobius.estimate.estimator import Estimator as Estimator
from mobius.estimate.estimator import EstimatorConfig as EstimatorConfig
