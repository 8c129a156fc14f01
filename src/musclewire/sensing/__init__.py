"""From voltages to strain: resistance (Eq. 1), segments A-B-C, gaps (Eq. 2), polynomials (Eqs. 3-5), models.

Source: Lan and Fan 2010, "Investigation on Pretensioned Shape Memory Alloy Actuators for Force and
Displacement Self-Sensing". Every function takes plain floats or arrays, time first; nothing here reads a
clock, a rig or the simulator.
"""

from __future__ import annotations

from musclewire.physics.resistance import (
    ArrayReading,
    ResistanceReading,
    wire_resistance,
    wire_resistance_from_current,
)
from musclewire.sensing.branch_equations import evaluate, normalised_resistance
from musclewire.sensing.branches import Branch, single_valued
from musclewire.sensing.curve import ArrayEstimate, CurveEstimate, ResistanceCurve
from musclewire.sensing.estimator import (
    ESTIMATORS,
    CompiledEstimator,
    Estimator,
    EstimatorFactory,
    EstimatorSetup,
    SlowPart,
)
from musclewire.sensing.fitting import fit_branches, fit_loop, fit_segments
from musclewire.sensing.gaps import hysteresis_gap, signed_hysteresis_gap
from musclewire.sensing.home_move import HomeMove
from musclewire.sensing.known_load import KnownSpring
from musclewire.sensing.model import SensingModel, load_model
from musclewire.sensing.polynomial_estimator import PolynomialEstimator, SegmentTracker, SegmentTrackerState
from musclewire.sensing.resistance_extremes import ResistanceExtremes, find_resistance_extremes
from musclewire.sensing.segments import LoopSegments, find_loops, find_segments

__all__ = [
    "ESTIMATORS",
    "Estimator",
    "CompiledEstimator",
    "EstimatorFactory",
    "EstimatorSetup",
    "HomeMove",
    "KnownSpring",
    "PolynomialEstimator",
    "SlowPart",
    "ResistanceReading",
    "ArrayReading",
    "wire_resistance",
    "wire_resistance_from_current",
    "LoopSegments",
    "find_segments",
    "find_loops",
    "Branch",
    "single_valued",
    "hysteresis_gap",
    "signed_hysteresis_gap",
    "normalised_resistance",
    "evaluate",
    "SensingModel",
    "ResistanceCurve",
    "CurveEstimate",
    "ArrayEstimate",
    "fit_loop",
    "fit_segments",
    "fit_branches",
    "load_model",
    "ResistanceExtremes",
    "find_resistance_extremes",
    "SegmentTracker",
    "SegmentTrackerState",
]
