"""A small estimator with a slow part, for the tests of what runs slow parts: an offset to the paper's."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from musclewire.sensing import EstimatorSetup, PolynomialEstimator, PolynomialState
from musclewire.signals import EstimatorStep, Reason, WireSample


class DriftingState(NamedTuple):
    paper: PolynomialState
    offset: float
    value: float


class MeanPower:
    """A correction of the quantity by the mean power over a window; ``meanwhile`` is what takes long."""

    window_ticks = 4

    def __init__(
        self, every_ticks: int = 10, after_ticks: int = 5, meanwhile: Callable[[], object] | None = None
    ) -> None:
        self.every_ticks, self.after_ticks = every_ticks, after_ticks
        self._meanwhile = meanwhile

    def correction(self, window: tuple[WireSample, ...]) -> float:
        if self._meanwhile is not None:
            self._meanwhile()
        return sum(sample.wire_voltage_v * sample.shunt_voltage_v for sample in window) / len(window)

    def corrected(self, state: DriftingState, correction: float) -> DriftingState:
        if not 0.0 <= correction < 100.0:
            raise ValueError(f"no wire takes {correction} W")
        return state._replace(offset=1e-4 * correction)


class DriftingEstimator:
    """The paper's estimate, plus an offset that only the slow part changes."""

    columns = ("wire_resistance_ohm", "extra_offset")
    has_c_form = False

    def __init__(self, paper: PolynomialEstimator, slow_part: MeanPower) -> None:
        self._paper, self.slow_part, self.quantity = paper, slow_part, paper.quantity

    def start(self) -> DriftingState:
        paper = self._paper.start()
        return DriftingState(paper, 0.0, paper.value)

    def step(self, state: DriftingState, sample: WireSample) -> EstimatorStep:
        estimate, paper, recorded = self._paper.step(state.paper, sample)
        value = state.value if estimate.reason is Reason.NO_CURRENT else estimate.value + state.offset
        return EstimatorStep(
            estimate._replace(value=value), DriftingState(paper, state.offset, value), (*recorded, state.offset)
        )


def drifting(**slow: object) -> Callable[[EstimatorSetup], DriftingEstimator]:
    """Return a factory of the estimator with a slow part of these numbers."""

    def drifting_estimator(setup: EstimatorSetup) -> DriftingEstimator:
        paper = PolynomialEstimator(setup.model, setup.shunt_resistance_ohm, setup.load)
        return DriftingEstimator(paper, MeanPower(**slow))  # type: ignore[arg-type]

    return drifting_estimator
