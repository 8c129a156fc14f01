"""Feedforward from the inverse model and the heat balance, and gain-scheduled feedback; state in, state out.

A wire in air is a first-order heat balance with hysteresis behind it:

    tau dw/dt = P - w - lambda dS/dt,   w = G (T - T_air)

P is the electrical power, w the power that would hold the present temperature, S the quantity and lambda the heat that
one unit of it takes. S rises only while w is on the heating branch w_h(S) and falls only on the cooling branch w_c(S);
between them it stands still. Both branches are known from a slow loop. So a new target is answered with:

- the steady power of its branch, w_h or w_c, which includes the gap between the branches if the direction turns;
- a pulse of heat, tau times that change plus lambda times the step, delivered as fast as the limits permit. What a
  limit holds back remains due: heating is fast, and cooling is as fast as still air lets it be;
- a PI on the error from where the wire should be by then. Its gain follows direction and strain:
  K_c = (tau dw/dS + lambda) / (tau_c + theta), T_i = min(tau_e, 4 (tau_c + theta)) (SIMC, Skogestad 2003).

Heating from cold is the same: below B resistance does not determine strain, so the heat alone brings the wire there.
No windup: the integral stops at a limit that it would press on. The heat balance of the commanded power never exceeds
that of the highest temperature.

What it cannot know it learns during a run, and says so in the recording:

- the gap: a wire that stands still on the wrong side of its target jumps over a part of it, and half as far from then
  on when that was too far;
- lateness (``lag_s``): how much later than expected the wire is half way at large steps; it is then expected later, and
  SIMC's tau_c and theta both grow by it;
- what the estimate is worth: an error counts for the integral as far as it is above the estimate's deviation, and a
  wire that has come to rest is not pushed about by less;
- an oscillation (``gain_factor``): a drive that swings to and fro at one target halves the gain from then on;
- C (``beyond_c``): where more power than the slow loop ever took makes the estimate fall back, less is tried; if the
  estimate does not fall then, the wire is beyond C, where resistance rises with temperature, and gets no more than
  the slow loop's largest power.

References: Skogestad 2003, doi 10.1016/S0959-1524(02)00062-8, for the rule of K_c and T_i.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from musclewire.arrays import FloatArray
from musclewire.controllers._controller import ControllerSetup, settings_of_kind, step_error
from musclewire.controllers._schema import StrictModel
from musclewire.errors import CallerError
from musclewire.signals import CONTROLLER_ANSWERS, CompiledTick, ControlStep, Drive, QuantityEstimate

Positive = Annotated[float, Field(gt=0.0)]
# Times of a loop: a day is longer than any; beyond, an integral would be none.
Seconds = Annotated[float, Field(gt=0.0, le=86400.0)]
Table = Annotated[tuple[Positive, ...], Field(min_length=3)]
# A branch is never taken as flatter or steeper than its median by more than these factors: near the ends of the loop
# its slope is that of few samples.
FLATTEST, STEEPEST = 0.5, 4.0
SMOOTHED_LEVELS = 5


class FeedforwardSettings(StrictModel):
    """What the feedforward controller knows of a wire, and how fast it follows; ``musclewire.tune`` finds all of it.

    Parameters
    ----------
    quantity
        "strain", "displacement" or "force": the unit of ``lowest``, ``highest`` and ``tolerance``.
    lowest
        First level of the tables, in the quantity's SI unit.
    highest
        Last level of the tables; the levels between are evenly spaced.
    heating_power_w
        Electrical power [W] that holds each level on the heating branch.
    cooling_power_w
        The same [W] on the cooling branch, at no level above that of heating.
    resistance_ohm
        Resistance of the wire [ohm] at each level.
    shunt_resistance_ohm
        R of Eq. 1 [ohm], in series with the wire.
    thermal_time_constant_s
        Heat capacity over heat loss to the air [s].
    heat_per_unit
        Heat [J] that the transformation takes for one unit of the quantity.
    closed_loop_time_s
        tau_c [s]; SIMC recommends the dead time.
    dead_time_s
        theta [s]: from a command to its effect on the estimate.
    integral_time_s
        T_i [s].
    pulse_time_s
        Time constant [s] of the pulse of heat; three samples.
    tolerance
        Error, in the quantity's unit, from which a wire that stands still jumps over the gap; the deviation of the
        estimate, where that is larger.
    gap_fraction
        Fraction of the gap that the first jump takes; the rest is the feedback's, as no gap is known exactly.
    maximum_steady_power_w
        Power [W] in the heat balance at the highest permitted temperature.

    Raises
    ------
    CallerError
        For an unknown key, tables of different length, branches that cross, a number that is not positive, or a time of
        more than a day.
    """

    quantity: str = "strain"
    lowest: float
    highest: float
    heating_power_w: Table
    cooling_power_w: Table
    resistance_ohm: Table
    shunt_resistance_ohm: Positive
    thermal_time_constant_s: Seconds
    heat_per_unit: Annotated[float, Field(ge=0.0)]
    closed_loop_time_s: Seconds
    dead_time_s: Seconds
    integral_time_s: Seconds
    pulse_time_s: Seconds = 0.15
    tolerance: Positive
    gap_fraction: Annotated[float, Field(ge=0.0, le=1.0)] = 0.4
    maximum_steady_power_w: Positive

    @model_validator(mode="after")
    def _tables_fit_together(self) -> Self:
        if self.highest <= self.lowest:
            raise ValueError(f"highest ({self.highest:g}) must be above lowest ({self.lowest:g})")
        lengths = {len(self.heating_power_w), len(self.cooling_power_w), len(self.resistance_ohm)}
        if len(lengths) != 1:
            raise ValueError(f"the three tables must have one length, not {sorted(lengths)}")
        if any(c > h for h, c in zip(self.heating_power_w, self.cooling_power_w, strict=True)):
            raise ValueError(
                "cooling_power_w is above heating_power_w at a level: the branches are swapped, exchange the two rows"
            )
        for low, high in (pair for row in (self.heating_power_w, self.cooling_power_w) for pair in pairwise(row)):
            if high < low:
                raise ValueError(
                    f"the power of a branch must not fall from level to level, as from {low:g} to {high:g} W"
                )
        return self

    @property
    def levels(self) -> FloatArray:
        """Levels of the tables, in the quantity's unit, (n,)."""
        return np.linspace(self.lowest, self.highest, len(self.heating_power_w))

    def branch_slopes(self) -> tuple[FloatArray, FloatArray]:
        """Return the slopes of both branches at each level, smoothed and limited.

        Returns
        -------
        dw/dS of heating and of cooling branch [W per unit of the quantity], (n,) each.
        """
        return smoothed_slope(self.heating_power_w, self.levels), smoothed_slope(self.cooling_power_w, self.levels)


def smoothed_slope(power_w: tuple[float, ...], levels: FloatArray) -> FloatArray:
    """Return the slope of a branch over its levels, a mean of five, within bounds about its median."""
    half = SMOOTHED_LEVELS // 2
    padded = np.pad(np.gradient(np.asarray(power_w), levels), half, mode="edge")
    slope = np.convolve(padded, np.full(SMOOTHED_LEVELS, 1.0 / SMOOTHED_LEVELS), "valid")
    middle = float(np.median(slope))
    return np.asarray(np.clip(slope, FLATTEST * middle, STEEPEST * middle))


class FeedforwardController:
    """Feedforward of steady power and heat, and a gain-scheduled PI; brings a cold wire to its first target at once.

    Parameters
    ----------
    setup
        Limits of the drive, and ``FeedforwardSettings``.

    Raises
    ------
    CallerError
        Without settings, or with those of another controller.
    """

    columns = ("steady_power_w", "pending_heat_j", "gain_factor", "beyond_c", "lag_s")
    # The first target is reached from cold within its first second, so it needs no time before the first step.
    approach_s = 0.0

    def __init__(self, setup: ControllerSetup) -> None:
        """Take limits and settings, and pack them for the tick."""
        from musclewire.controllers import _feedforward_kernel as feedforward_kernel

        if setup.settings is None:
            raise CallerError(
                "the controller feedforward needs the gains of its wire: fit keeps them in a new model, and for this "
                "one they are settings=tune(model, recording).settings"
            )
        self.settings: FeedforwardSettings = settings_of_kind(setup, FeedforwardSettings)
        self.limits = setup.limits
        self._kernel: Any = feedforward_kernel
        self._constants = self._packed()
        self.step(self.start(self.limits.sense_voltage_v), 0.0, QuantityEstimate(0.0, 0.0, True), 1.0)

    def _packed(self) -> FloatArray:
        """Return limits, settings and tables as the array that the tick reads."""
        settings, kernel = self.settings, self._kernel
        known = {
            **settings.model_dump(),
            "sense_voltage_v": self.limits.sense_voltage_v,
            "maximum_voltage_v": self.limits.maximum_voltage_v,
            "response_s": settings.closed_loop_time_s + settings.dead_time_s,
            "spacing": (settings.highest - settings.lowest) / (len(settings.heating_power_w) - 1),
        }
        known["heating_slope"], known["cooling_slope"] = settings.branch_slopes()
        numbers = [known[name] for name in kernel.SETTINGS.names]
        return np.concatenate([numbers, *(known[name] for name in kernel.TABLES)])

    def start(self, drive_voltage_v: float) -> tuple[float, ...]:
        """Return the state before the first estimate: the applied drive [V], within the limits."""
        state = np.zeros(1, self._kernel.STATE)
        state["drive_voltage_v"] = self.limits.clamp(float(drive_voltage_v))
        return tuple(state.view(np.float64).tolist())

    def step(self, state: tuple[float, ...], target: float, estimate: QuantityEstimate, dt_s: float) -> ControlStep:
        """Return the drive for an estimate; without current the last one."""
        numbers, answer = np.array(state), np.zeros(len(CONTROLLER_ANSWERS) + len(self.columns))
        value, std, valid, reason, _ = estimate
        given = np.array((float(target), float(value), float(std), float(valid), float(reason), float(dt_s)))
        self._kernel.feedforward_tick(self._constants, numbers, given, answer)
        drive_voltage_v, failed, *recorded = answer.tolist()
        if failed:
            raise step_error(target, value, dt_s)
        return ControlStep(Drive(drive_voltage_v), tuple(numbers.tolist()), tuple(recorded))

    def compiled_tick(self, drive_voltage_v: float) -> CompiledTick:
        """Return ``step`` as a compiled function."""
        return CompiledTick(self._kernel.feedforward_tick, self._constants, np.array(self.start(drive_voltage_v)))
