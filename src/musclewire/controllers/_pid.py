"""A plain PID in velocity form: the law of ``_fuzzy_pid`` with constant gains.

    du = input_scale * [ K_p (e_k - e_(k-1)) + K_I dt e_k - K_D (r_k - r_(k-1)) ]   volts

with the error e in percent strain and r the filtered rate of the measured value.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from musclewire.controllers._controller import PERCENT_STRAIN, ControllerSetup, settings_of_kind
from musclewire.controllers._fuzzy_pid import FuzzyPidController, FuzzyPidSettings
from musclewire.controllers._schema import StrictModel


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

    of_controller: ClassVar[str] = "pid"
    kp: Annotated[float, Field(ge=0.0)] = 0.06
    ki: Annotated[float, Field(ge=0.0)] = 0.04
    kd: Annotated[float, Field(ge=0.0)] = 0.00075
    input_scale: Annotated[float, Field(gt=0.0)] = 20.0
    error_unit: Annotated[float, Field(gt=0.0)] = PERCENT_STRAIN
    derivative_filter_s: Annotated[float, Field(ge=0.0)] = 0.2


def pid_controller(setup: ControllerSetup) -> FuzzyPidController:
    """Return a plain PID, the fuzzy one with one number for each range; a unit that settings name is kept."""
    settings: PidSettings = settings_of_kind(setup, PidSettings)
    named = "error_unit" in settings.model_fields_set
    constant = FuzzyPidSettings(
        kp_range=(settings.kp, settings.kp),
        ki_range=(settings.ki, settings.ki),
        kd_range=(settings.kd, settings.kd),
        input_scale=settings.input_scale,
        error_unit=settings.error_unit if named else setup.error_unit,
        derivative_filter_s=settings.derivative_filter_s,
        rule_base="fixed",
    )
    return FuzzyPidController(constant, setup.limits)
