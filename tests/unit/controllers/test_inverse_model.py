"""The inverse of the wire's model on a wire of ten lines: with the state that a filter would find, and without."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers import ControllerSetup, DriveLimits, FeedforwardSettings, InverseModelController
from musclewire.controllers._inverse_model import STATE
from musclewire.errors import CallerError, NumericsError
from musclewire.signals import Drive, QuantityEstimate, Reason, WireEstimate

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


CONTROLLER = InverseModelController(ControllerSetup(LIMITS, settings=KNOWN))
CENTRE_W = 0.30  # of the gap between both branches at the lowest level, which is 0.1 W wide everywhere


# What holds that wire at 2 % in the middle between its branches.
RESTS_W, RESTS_OHM = CENTRE_W + 5.0 * 0.015, 17.4 - 1.1
RESTS_V = (RESTS_OHM + 1.0) * math.sqrt(RESTS_W / RESTS_OHM)


class SeenWire(PlayWire):
    """The wire with a weaker supply or other air, and what a filter would know of it."""

    def __init__(self, loss: float = 1.0, supply: float = 1.0) -> None:
        super().__init__(loss)
        self.supply = supply

    def seen_after(self, drive_v: float) -> QuantityEstimate:
        read = self.after(self.supply * drive_v)
        resistance = 17.4 - 2.2 / 0.03 * min(max(self.strain - 0.005, 0.0), 0.03)
        power_w = (self.supply * drive_v / (resistance + 1.0)) ** 2 * resistance
        part = (self.balance_w - CENTRE_W - 5.0 * (self.strain - 0.005)) / 0.1 + 0.5
        wire = WireEstimate(self.balance_w, min(max(part, 0.0), 1.0), 0.0, self.loss, power_w)
        return read._replace(wire=wire)


def followed(
    wire: SeenWire,
    targets: list[float],
    *,
    state_is_known: bool = True,
    controller: InverseModelController = CONTROLLER,
) -> tuple[np.ndarray, np.ndarray]:
    """Return strain and drive over the samples of a loop from cold."""
    state, drive_v, rows = controller.start(LIMITS.sense_voltage_v), LIMITS.sense_voltage_v, []
    for target in targets:
        read = wire.seen_after(drive_v)
        step = controller.step(state, target, read if state_is_known else read._replace(wire=None), DT_S)
        assert isinstance(step.command, Drive)
        state, drive_v = step.state, step.command.voltage_v
        rows.append((wire.strain, drive_v))
    strain, drives = np.array(rows).T
    return strain, drives


@pytest.mark.parametrize("known", [True, False], ids=["state", "quantity alone"])
def test_a_step_from_cold_does_not_overshoot_and_rests(known: bool) -> None:
    strain, drives = followed(SeenWire(), [0.02] * 160, state_is_known=known)
    assert strain[40:] == pytest.approx(0.02, rel=0.01)
    assert strain.max() < 0.02 * 1.01
    assert np.ptp(drives[80:]) < 0.05


@pytest.mark.parametrize("known", [True, False], ids=["state", "quantity alone"])
@given(levels=st.lists(st.floats(0.008, 0.032), min_size=2, max_size=4))
def test_any_steps_end_within_one_percent(known: bool, levels: list[float]) -> None:
    strain, _ = followed(SeenWire(), [level for level in levels for _ in range(100)], state_is_known=known)
    for number, level in enumerate(levels):
        assert strain[100 * number + 95] == pytest.approx(level, abs=2.5e-4)


@pytest.mark.parametrize("known", [True, False], ids=["state", "quantity alone"])
@pytest.mark.parametrize("loss", [0.7, 1.4])
def test_other_air_is_answered(known: bool, loss: float) -> None:
    strain, _ = followed(SeenWire(loss), [0.02] * 200, state_is_known=known)
    assert strain[100:] == pytest.approx(0.02, rel=0.015)


@pytest.mark.parametrize("known", [True, False], ids=["state", "quantity alone"])
def test_a_step_of_the_paper_is_done_within_half_a_second_and_back_within_one(known: bool) -> None:
    strain, _ = followed(
        SeenWire(), [level for level in (0.015, 0.018, 0.015) for _ in range(120)], state_is_known=known
    )
    ten = round(0.5 / DT_S)
    assert strain[120 + ten] >= 0.015 + 0.9 * 0.003
    assert strain[240 + 2 * ten] <= 0.018 - 0.9 * 0.003


@given(st.floats(0.006, 0.06), st.floats(0.3, 0.6))
def test_a_wire_never_becomes_warmer_than_the_highest_steady_power_holds(target: float, limit_w: float) -> None:
    settings = KNOWN.model_copy(update={"maximum_steady_power_w": limit_w})
    wire, controller = SeenWire(), InverseModelController(ControllerSetup(LIMITS, settings=settings))
    followed(wire, [target] * 80, controller=controller)
    # A drive is held for a sample, while resistance falls by a few percent and power rises by as much.
    assert wire.warmest_w <= 1.03 * limit_w


@pytest.mark.parametrize("known", [True, False], ids=["state", "quantity alone"])
@pytest.mark.parametrize("loss", [0.9, 1.0, 1.1])
def test_a_slow_sine_is_followed_though_the_wire_loses_more_heat_than_is_known(known: bool, loss: float) -> None:
    times_s = np.arange(0.0, 90.0, DT_S)
    targets = 0.02 + 0.008 * np.sin(2.0 * np.pi * times_s / 30.0)
    strain, _ = followed(SeenWire(loss), targets.tolist(), state_is_known=known)
    error = (np.abs(strain - targets) / targets)[times_s > 2.0]
    assert float(error.mean()) < 0.02
    assert float(error.max()) < 0.1


def test_a_weak_supply_is_noticed_by_the_measured_power() -> None:
    strain, _ = followed(SeenWire(supply=0.85), [0.02] * 300)
    assert strain[200:] == pytest.approx(0.02, rel=0.01)


def test_a_target_that_moves_is_met_where_it_will_be() -> None:
    time_s = DT_S * np.arange(600)
    targets = 0.02 + 0.006 * np.sin(2.0 * np.pi * time_s / 20.0)
    strain, _ = followed(SeenWire(), targets.tolist())
    shown = slice(200, -1)
    assert np.abs(strain - np.roll(targets, 1))[shown].mean() < 1.5e-4


def test_a_jump_has_no_rate_and_a_ramp_has_its_own() -> None:
    """Of two equal errors the one of a moving target takes more power, by the heat of the way that it goes."""

    def power_at(before: float) -> float:
        state = CONTROLLER.start(RESTS_V)
        for target in (before, before, 0.5 * (before + 0.02), 0.02):
            step = CONTROLLER.step(state, target, resting(), DT_S)
            state = step.state
        assert isinstance(step.command, Drive)
        return step.command.voltage_v

    assert power_at(0.02) < power_at(0.0198)
    assert power_at(0.02) == pytest.approx(RESTS_V)


def resting(std: float = 1e-4) -> QuantityEstimate:
    """Return a wire at 2 % in the middle between its branches, held by its power."""
    return QuantityEstimate(0.02, std, True, Reason.OK, wire=WireEstimate(RESTS_W, 0.5, 0.0, 1.0, RESTS_W))


@given(st.floats(-1e-4, 1e-4), st.floats(2e-3, 1e-2))
def test_what_is_far_below_the_deviation_hardly_moves_the_drive(error: float, std: float) -> None:
    """The drive of a wire at rest within its interval changes by less than 2 %."""
    state = CONTROLLER.start(RESTS_V)
    for _ in range(20):
        step = CONTROLLER.step(state, 0.02 + error, resting(std), DT_S)
        assert isinstance(step.command, Drive)
        state = step.state
        assert step.command.voltage_v == pytest.approx(RESTS_V, rel=0.02)


@given(st.floats(0.005, 0.035), st.floats(0.0, 1.0), st.floats(0.006, 0.034))
def test_the_heat_balance_never_goes_above_the_highest_steady_power(value: float, part: float, target: float) -> None:
    wire = WireEstimate(0.97, part, 0.0, 1.0, 0.9)
    state = CONTROLLER.start(3.0)
    step = CONTROLLER.step(state, target, QuantityEstimate(value, 1e-4, True, Reason.OK, wire=wire), DT_S)
    assert isinstance(step.command, Drive)
    resistance = np.interp(value, KNOWN.levels, KNOWN.resistance_ohm)
    power_w = (step.command.voltage_v / (resistance + 1.0)) ** 2 * resistance
    assert 0.97 + (power_w - 0.97) * DT_S / 0.8 <= KNOWN.maximum_steady_power_w + 1e-9 or power_w < 0.01


def test_without_current_the_drive_stays_and_nothing_is_learnt() -> None:
    state = CONTROLLER.start(RESTS_V)
    for _ in range(3):
        state = CONTROLLER.step(state, 0.02, resting(), DT_S).state
    after = CONTROLLER.step(state, 0.03, QuantityEstimate(0.02, 0.03, False, Reason.NO_CURRENT), DT_S)
    assert after.state == state


class WronglySeenWire(SeenWire):
    """The wire, of which the first estimates are wrong."""

    def __init__(self, wrong: list[float]) -> None:
        super().__init__()
        self.wrong = list(wrong)

    def seen_after(self, drive_v: float) -> QuantityEstimate:
        read = super().seen_after(drive_v)
        return read._replace(value=self.wrong.pop(0), valid=True, reason=Reason.OK) if self.wrong else read


@given(wrong=st.lists(st.floats(0.0, 0.04), min_size=1, max_size=5))
def test_wrong_estimates_of_a_cold_wire_do_not_keep_it_cold(wrong: list[float]) -> None:
    """What they say of the air is corrected by a wire that stays cold where it should have contracted."""
    strain, _ = followed(WronglySeenWire(wrong), [0.02] * 160, state_is_known=False)
    assert strain[120:] == pytest.approx(0.02, rel=0.05)


def test_a_reading_of_another_wire_is_no_weak_supply() -> None:
    """It measures no power: the part of the asked power that the wire is given stays as it was."""
    given_part, state = (STATE.names or ()).index("given_part"), CONTROLLER.start(RESTS_V)
    for _ in range(3):
        state = CONTROLLER.step(state, 0.02, resting(), DT_S).state
    other = QuantityEstimate(0.02, 0.03, False, Reason.MISMATCH, wire=WireEstimate(RESTS_W, 0.5, 0.0, 1.0, 0.0))
    for _ in range(9):
        after = CONTROLLER.step(state, 0.02, other, DT_S)
        assert after.state[given_part] == state[given_part]
        state = after.state


@pytest.mark.parametrize("std", [math.nan, math.inf])
def test_a_deviation_that_is_no_number_is_refused(std: float) -> None:
    with pytest.raises(NumericsError):
        CONTROLLER.step(CONTROLLER.start(1.5), 0.02, resting(std), DT_S)


def test_it_has_no_more_numbers_of_state_than_ten() -> None:
    assert len(STATE.names or ()) == 10
    assert math.isfinite(sum(CONTROLLER.start(1.0)))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"cooling_power_w": (0.4, 0.45, 0.5, 0.55)}, "swapped"),
        ({"resistance_ohm": (17.0, 16.0, 15.0)}, "one length"),
        ({"highest": 0.001}, "above lowest"),
        ({"heating_power_w": (0.35, 0.34, 0.45, 0.5)}, "must not fall"),
        *(({name: 1e5}, name) for name in FeedforwardSettings.model_fields if name.endswith("time_s")),
        ({"dead_time": 1e-4}, "did you mean 'dead_time_s'"),
    ],
)
def test_settings_that_cannot_be_are_refused(changed: dict[str, object], message: str) -> None:
    with pytest.raises(CallerError, match=message):
        FeedforwardSettings(**{**KNOWN.model_dump(), **changed})
    with pytest.raises(CallerError, match="fit keeps them in a new model"):
        InverseModelController(ControllerSetup(LIMITS))
