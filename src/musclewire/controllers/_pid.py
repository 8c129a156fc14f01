"""A plain PID in velocity form: constant gains, the law of ``fuzzy_pid`` without its tuning; state in, state out.

    du = input_scale * [ K_p (e_k - e_(k-1)) + K_I dt e_k - K_D (r_k - r_(k-1)) ]   volts

with the error e in percent strain and r the filtered rate of the measured value. The reasons in ``fuzzy_pid``
(velocity form, derivative on the measured value, no windup, missing measurements) apply here too. It is plain Python: a
tick takes about as long as the call of a compiled one.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from musclewire.controllers._controller import PERCENT_STRAIN, ControllerSetup, settings_of_kind
from musclewire.controllers._drive_limits import DriveLimits
from musclewire.controllers._schema import StrictModel
from musclewire.errors import CallerError, NumericsError
from musclewire.signals import CompiledTick, ControlStep, Drive, QuantityEstimate, Reason

__all__ = ["PidController", "PidSettings", "PidState", "pid_controller"]


class PidSettings(StrictModel):
    """The numbers of a plain PID; the gains default to the middles of the paper's ranges.

    Parameters
    ----------
    kp
        K_p, no unit.
    ki
        K_I [1/s].
    kd
        K_D [s].
    input_scale
        Volts per error unit at a gain of one; the default is that of the fuzzy-tuned PID.
    error_unit
        Amount of the controlled quantity that corresponds to one percent strain, in its SI unit.
    derivative_filter_s
        Time constant [s] of the rate filter, four samples of 50 ms; 0 for none.

    Raises
    ------
    CallerError
        If a key is unknown or a number not positive.
    """

    kp: Annotated[float, Field(ge=0.0)] = 0.06
    ki: Annotated[float, Field(ge=0.0)] = 0.04
    kd: Annotated[float, Field(ge=0.0)] = 0.00075
    input_scale: Annotated[float, Field(gt=0.0)] = 20.0
    error_unit: Annotated[float, Field(gt=0.0)] = PERCENT_STRAIN
    derivative_filter_s: Annotated[float, Field(ge=0.0)] = 0.2


class PidState(NamedTuple):
    """The state of a plain PID; ``rates_known`` is False after a sample without current."""

    drive_voltage_v: float
    error: float
    measured: float
    measured_rate: float
    rates_known: bool


class PidController:
    """A plain PID within drive limits.

    Parameters
    ----------
    settings
        Gains and scales.
    limits
        Range of the drive voltage [V].
    """

    columns = ("proportional_gain", "integral_gain", "derivative_gain")

    def __init__(self, settings: PidSettings, limits: DriveLimits) -> None:
        """Take the settings and the limits."""
        self.settings, self.limits = settings, limits
        self._gains = (settings.kp, settings.ki, settings.kd)

    def start(self, drive_voltage_v: float) -> Drive:
        """Return the state before the first estimate: the applied drive [V], within the limits."""
        return Drive(self.limits.clamp(float(drive_voltage_v)))

    def step(self, state: Drive | PidState, target: float, estimate: QuantityEstimate, dt_s: float) -> ControlStep:
        """Return the drive for an estimate; without current the last one, and no gains."""
        if estimate.reason is Reason.NO_CURRENT:
            if isinstance(state, Drive):
                return ControlStep(state, state, (0.0, 0.0, 0.0))
            return ControlStep(
                Drive(state.drive_voltage_v), state._replace(measured_rate=0.0, rates_known=False), (0.0, 0.0, 0.0)
            )
        if not (math.isfinite(estimate.value) and math.isfinite(target)):
            raise NumericsError(f"controller step with target {target}, measured {estimate.value}: both must be finite")
        if not (dt_s > 0.0 and math.isfinite(dt_s)):
            raise CallerError(f"controller step with dt_s {dt_s}: the time since the last step must be above zero")
        if isinstance(state, Drive):
            state = PidState(state.voltage_v, target - estimate.value, estimate.value, 0.0, True)
        following = self._after(state, target, estimate.value, dt_s)
        return ControlStep(Drive(following.drive_voltage_v), following, self._gains)

    def compiled_tick(self, drive_voltage_v: float) -> CompiledTick:
        """Return ``step`` as a compiled function."""
        from musclewire.controllers import _compiled_ticks as compiled_ticks

        state = np.zeros(1, compiled_ticks.PID_STATE)
        state["drive_voltage_v"] = self.limits.clamp(float(drive_voltage_v))
        known = {**self.settings.model_dump(), **asdict(self.limits)}
        constants = np.array([known[name] for name in compiled_ticks.PID_SETTINGS.names or ()])
        return CompiledTick(compiled_ticks.pid_tick, constants, state.view(np.float64))

    def _after(self, state: PidState, target: float, measured: float, dt_s: float) -> PidState:
        """Return the next state by the law in velocity form."""
        error, rate = target - measured, 0.0
        if state.rates_known:
            weight = dt_s / (self.settings.derivative_filter_s + dt_s)
            rate = state.measured_rate + weight * ((measured - state.measured) / dt_s - state.measured_rate)
        kp, ki, kd = self._gains
        parts = kp * (error - state.error) + ki * dt_s * error - kd * (rate - state.measured_rate)
        drive_v = state.drive_voltage_v + self.settings.input_scale * parts / self.settings.error_unit
        if not math.isfinite(drive_v):
            raise NumericsError(f"controller step with target {target}, measured {measured} overflows; check the units")
        return PidState(self.limits.clamp(drive_v), error, measured, rate, True)


def pid_controller(setup: ControllerSetup) -> PidController:
    """Return a plain PID for a loop.

    Parameters
    ----------
    setup
        Limits, error unit, and ``PidSettings`` or None. Settings that name an error unit keep it.

    Returns
    -------
    The controller.

    Raises
    ------
    CallerError
        If the settings are another controller's.
    """
    settings: PidSettings = settings_of_kind(setup, PidSettings)
    if "error_unit" not in settings.model_fields_set:
        settings = settings.model_copy(update={"error_unit": setup.error_unit})
    return PidController(settings, setup.limits)
