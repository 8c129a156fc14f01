"""The feedforward controller on a wire written down in ten lines: heat balance, and play between two branches."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.arrays import FloatArray
from musclewire.controllers._controller import ControllerSetup
from musclewire.controllers._drive_limits import DriveLimits
from musclewire.controllers._feedforward import FeedforwardController, FeedforwardSettings
from musclewire.errors import CallerError
from musclewire.signals import Drive, QuantityEstimate, Reason

LIMITS = DriveLimits(0.3, 3.6)
DT_S = 0.05
KNOWN = FeedforwardSettings(
    lowest=0.005,
    highest=0.035,
    heating_power_w=(0.35, 0.40, 0.45, 0.50),
    cooling_power_w=(0.25, 0.30, 0.35, 0.40),
    resistance_ohm=(17.4, 17.4 - 2.2 / 3.0, 15.2 + 2.2 / 3.0, 15.2),
    shunt_resistance_ohm=1.0,
    thermal_time_constant_s=0.8,
    heat_per_unit=2.5,
    closed_loop_time_s=0.1,
    dead_time_s=0.1,
    integral_time_s=0.8,
    tolerance=2e-4,
    maximum_steady_power_w=0.98,
)
SLOPE_W = 5.0  # of both branches, per unit strain


class PlayWire:
    """A wire with straight branches 0.1 W apart; ``loss`` scales its loss to the air, cold below 0.5 %."""

    def __init__(self, loss: float = 1.0) -> None:
        self.loss, self.balance_w, self.strain, self.warmest_w = loss, 0.0, 0.0, 0.0

    def after(self, drive_v: float) -> QuantityEstimate:
        for _ in range(50):
            resistance = 17.4 - 2.2 / 0.03 * min(max(self.strain - 0.005, 0.0), 0.03)
            power = (drive_v / (resistance + 1.0)) ** 2 * resistance
            heating = self.balance_w > 0.35 + SLOPE_W * (self.strain - 0.005)
            cooling = self.balance_w < 0.25 + SLOPE_W * (self.strain - 0.005) and self.strain > 0.0
            tau_s = 0.8 + (2.5 / SLOPE_W if heating or cooling else 0.0)
            change = 0.001 * (power - self.loss * self.balance_w) / tau_s
            self.balance_w += change
            if heating:
                self.strain = max(self.strain, 0.005 + (self.balance_w - 0.35) / SLOPE_W)
            elif cooling:
                self.strain = max(min(self.strain, 0.005 + (self.balance_w - 0.25) / SLOPE_W), 0.0)
            self.warmest_w = max(self.warmest_w, self.balance_w)
        cold = self.strain < 0.005
        return QuantityEstimate(self.strain if not cold else 0.006, 1e-4, not cold, Reason.COLD if cold else Reason.OK)


def follow(
    targets: list[float], hold_s: float = 6.0, loss: float = 1.0, **changed: float
) -> tuple[PlayWire, list[float]]:
    """Return the wire and its strains after every sample."""
    controller = FeedforwardController(ControllerSetup(LIMITS, settings=KNOWN.model_copy(update=changed)))
    wire, strains = PlayWire(loss), []
    state, estimate = controller.start(0.3), PlayWire().after(0.3)
    for target in targets:
        for _ in range(round(hold_s / DT_S)):
            command, state, _ = controller.step(state, target, estimate, DT_S)
            assert isinstance(command, Drive)
            estimate = wire.after(command.voltage_v)
            strains.append(wire.strain)
    return wire, strains


def test_a_cold_wire_is_at_its_first_target_within_a_second_and_a_half() -> None:
    _, strains = follow([0.015])
    assert all(strain == pytest.approx(0.015, rel=0.03) for strain in strains[30:])


def test_a_step_of_the_paper_is_done_within_half_a_second_both_ways() -> None:
    _, strains = follow([0.015, 0.018, 0.015])
    ten = round(0.5 / DT_S)
    assert strains[120 + ten] >= 0.015 + 0.9 * 0.003
    assert strains[240 + 2 * ten] <= 0.018 - 0.9 * 0.003


def test_what_the_steady_power_grew_by_without_an_estimate_is_given_back_with_the_first_one() -> None:
    strong = KNOWN.model_copy(update={"maximum_steady_power_w": 3.0})
    controller = FeedforwardController(ControllerSetup(DriveLimits(0.3, 5.0), settings=strong))
    steady = controller.columns.index("steady_power_w")
    state, cold = controller.start(0.3), QuantityEstimate(0.006, 1e-4, False, Reason.COLD)
    _, state, first = controller.step(state, 0.015, cold, DT_S)
    for _ in range(9):
        _, state, blind = controller.step(state, 0.015, cold, DT_S)
    _, _, sensed = controller.step(state, 0.015, QuantityEstimate(0.0149, 1e-4, True), DT_S)
    assert blind[steady] > first[steady] + 0.01
    assert sensed[steady] == pytest.approx(first[steady], abs=2e-3)


@pytest.mark.parametrize("loss", [0.8, 1.2])
def test_feedback_removes_what_the_feedforward_does_not_know(loss: float) -> None:
    _, strains = follow([0.015, 0.018, 0.021, 0.018], hold_s=10.0, loss=loss)
    for index, target in enumerate([0.015, 0.018, 0.021, 0.018]):
        assert strains[200 * (index + 1) - 1] == pytest.approx(target, abs=4e-4)


@given(st.floats(0.006, 0.06), st.floats(0.3, 0.6))
def test_the_heat_balance_never_exceeds_the_highest_temperature(target: float, limit_w: float) -> None:
    wire, _ = follow([target], hold_s=4.0, maximum_steady_power_w=limit_w)
    # A drive is held for a sample, while resistance falls by a few percent and power rises by as much.
    assert wire.warmest_w <= 1.03 * limit_w


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"cooling_power_w": (0.4, 0.45, 0.5, 0.55)}, "swapped"),
        ({"resistance_ohm": (17.0, 16.0, 15.0)}, "one length"),
        ({"highest": 0.001}, "above lowest"),
        ({"heating_power_w": (0.35, 0.34, 0.45, 0.5)}, "must not fall"),
        *(({name: 1e5}, name) for name in FeedforwardSettings.model_fields if name.endswith("time_s")),
        ({"toleranse": 1e-4}, "did you mean 'tolerance'"),
    ],
)
def test_settings_that_cannot_be_are_refused(changed: dict[str, object], message: str) -> None:
    with pytest.raises(CallerError, match=message):
        FeedforwardSettings(**{**KNOWN.model_dump(), **changed})
    with pytest.raises(CallerError, match="fit keeps them in a new model"):
        FeedforwardController(ControllerSetup(LIMITS))


def test_a_slow_sine_is_followed_as_a_step_is_though_the_wire_loses_more_heat_than_is_known() -> None:
    times_s = np.arange(0.0, 90.0, DT_S)
    targets = 0.02 + 0.008 * np.sin(2.0 * np.pi * times_s / 30.0)
    for loss in (0.9, 1.0, 1.1):
        _, strains = follow(targets.tolist(), hold_s=DT_S, loss=loss)
        error = (np.abs(np.array(strains) - targets) / targets)[times_s > 2.0]
        assert float(error.mean()) < 0.02, loss
        assert float(error.max()) < 0.1, loss


def gain_factor_of_a_swinging_wire(targets: FloatArray) -> float:
    """Return what is left of the gain where the estimate swings by 0.4 % strain about a target at 1 Hz."""
    controller = FeedforwardController(ControllerSetup(LIMITS, settings=KNOWN))
    state, gain = controller.start(2.5), controller.columns.index("gain_factor")
    factor = 1.0
    for index, target in enumerate(targets.tolist()):
        swings = 4e-3 * math.sin(2.0 * math.pi * index * DT_S)
        _, state, columns = controller.step(state, target, QuantityEstimate(target + swings, 1e-4, True), DT_S)
        factor = columns[gain]
    return factor


def test_an_oscillation_is_noticed_at_a_target_that_moves_and_not_where_the_target_itself_swings() -> None:
    times_s = np.arange(0.0, 10.0, DT_S)
    assert gain_factor_of_a_swinging_wire(0.02 + 1e-4 * times_s) < 1.0
    assert gain_factor_of_a_swinging_wire(0.02 + 1e-4 * np.floor(times_s / 0.5)) < 1.0
    assert gain_factor_of_a_swinging_wire(0.02 + 2e-3 * np.sin(2.0 * np.pi * times_s)) == 1.0
