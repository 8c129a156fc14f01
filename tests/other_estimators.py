"""A small estimator as another package may bring it: its own state, its own column, no compiled form."""

from __future__ import annotations

from typing import NamedTuple

from musclewire.sensing import EstimatorSetup, PolynomialEstimator, PolynomialState
from musclewire.signals import EstimatorStep, Reason, WireSample


class DriftingState(NamedTuple):
    paper: PolynomialState
    offset: float
    value: float


class DriftingEstimator:
    """The paper's estimate, plus an offset that grows with every sample that can be read."""

    columns = ("wire_resistance_ohm", "offset")
    has_c_form = False

    def __init__(self, setup: EstimatorSetup) -> None:
        self._paper = PolynomialEstimator(setup.model.curve(), setup.shunt_resistance_ohm, setup.load)
        self.quantity = self._paper.quantity

    def start(self) -> DriftingState:
        paper = self._paper.start()
        return DriftingState(paper, 0.0, paper.value)

    def step(self, state: DriftingState, sample: WireSample) -> EstimatorStep:
        estimate, paper, recorded = self._paper.step(state.paper, sample)
        read = estimate.reason is not Reason.NO_CURRENT
        offset = state.offset + 1e-7 if read else state.offset
        value = estimate.value + offset if read else state.value
        return EstimatorStep(estimate._replace(value=value), DriftingState(paper, offset, value), (*recorded, offset))
