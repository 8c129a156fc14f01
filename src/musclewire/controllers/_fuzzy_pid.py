"""The fuzzy-tuned PID of the paper's section III (Fig. 10, Eq. 6): state in, state out.

The paper prints gain ranges (K_p 0.01..0.11, K_I 0.02..0.06, K_D 0.0005..0.001) but neither their units nor
the form of the law. The reading chosen here is the velocity form, with the error e in percent strain:

    du = input_scale * [ K_p (e_k - e_(k-1)) + K_I dt e_k + K_D/dt (e_k - 2 e_(k-1) + e_(k-2)) ]   volts

K_p has no unit, K_I is per second, K_D in seconds, and ``input_scale`` is one number of volts per percent
strain, the same for every step and every rig. Why: read literally, as volts per 50 ms sample without a
scale, the printed gains are 10 to 20 times too small to follow 0.3 % steps in six seconds, or they
oscillate. One scale keeps the printed ranges and their proportions.

Four decisions the paper leaves open:

- The derivative acts on the measured value, so a target step gives no kick, and passes a first-order filter
  of time constant ``derivative_filter_s``. The proportional part acts on the error. With a constant target
  and no filter the law is exactly the one above.
- The change of error that enters the fuzzy tables is the error's rate through the same kind of filter;
  target steps are part of it, as in the paper's Fig. 10.
- Anti-windup is inherent: the state holds the drive as it was clamped, and nothing else integrates. So the
  drive leaves a limit at the latest in the very tick in which the error changes its sign, however long it had
  been there. (Later only if the measured value brakes hard in that tick: the derivative part then requires
  more.)
- A missing measurement is bridged by ``hold``: the drive stays, the rates are forgotten. The next step still
  sees the whole change of the error since, so its proportional part catches up, while its derivative starts
  from rest.

The fuzzy ratios only choose gains inside their ranges, and in the velocity form a gain multiplies an
increment, so a change of gains does not move the drive by itself.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from musclewire.controllers._controller import PERCENT_STRAIN, ControllerSetup, settings_of_kind
from musclewire.controllers._drive_limits import DriveLimits
from musclewire.controllers._fuzzy import packed_rules
from musclewire.controllers._rules import DEFAULT_RULE_BASE, RuleBase, load_rule_base
from musclewire.controllers._schema import StrictModel
from musclewire.errors import CallerError, NumericsError
from musclewire.signals import CompiledTick, ControlStep, Drive, QuantityEstimate, Reason

__all__ = [
    "GAIN_COLUMNS",
    "ControllerState",
    "FuzzyPid",
    "FuzzyPidController",
    "FuzzyPidSettings",
    "StepResult",
    "fuzzy_pid_controller",
    "packed_settings",
    "with_error_unit",
]

# What every tick compares with: to look up a member of an enumeration takes longer than to compare it.
NO_CURRENT = Reason.NO_CURRENT
GAIN_COLUMNS = ("proportional_gain", "integral_gain", "derivative_gain")

Range: TypeAlias = tuple[Annotated[float, Field(ge=0.0)], Annotated[float, Field(ge=0.0)]]
Positive: TypeAlias = Annotated[float, Field(gt=0.0)]


class FuzzyPidSettings(StrictModel):
    """The settings of the fuzzy-tuned PID; the gain ranges default to the paper's.

    Parameters
    ----------
    kp_range
        Smallest and largest K_p, no unit.
    ki_range
        Smallest and largest K_I [1/s].
    kd_range
        Smallest and largest K_D [s].
    input_scale
        Drive voltage per error unit at a gain of one [V].
    error_unit
        Size of one percent strain in the controlled quantity: 0.01 for strain as a fraction; for a displacement [m] or
        a force [N] the amount that belongs to 1 % strain.
    error_range
        Error, in error units, at which the fuzzy tables' input is 1; two and a half of the paper's steps of 0.3 %.
    change_range
        Rate of the error, in error units per second, at which the tables' other input is 1; one of those steps within
        one sample of 0.05 s.
    derivative_filter_s
        Time constant of the rate filters [s], four samples; 0 for none.
    rule_base
        A name from ``rule_base_names()`` or the path of a .toml file; "fixed" turns the tuning off, and with both ends
        of each range equal the gains are that number.

    Raises
    ------
    CallerError
        For an unknown key (the message names the nearest), an inverted range, or a number that is not positive.

    References
    ----------
    Lan and Fan 2010, section III: the ranges of the gains.

    Examples
    --------
    >>> import musclewire as mw
    >>> mw.FuzzyPidSettings(kp_range=(0.01, 0.2)).ki_range
    (0.02, 0.06)
    """

    kp_range: Range = (0.01, 0.11)
    ki_range: Range = (0.02, 0.06)
    kd_range: Range = (0.0005, 0.001)
    input_scale: Positive = 20.0
    error_unit: Positive = 0.01
    error_range: Positive = 0.75
    change_range: Positive = 6.0
    derivative_filter_s: Annotated[float, Field(ge=0.0)] = 0.2
    rule_base: str = DEFAULT_RULE_BASE

    @field_validator("kp_range", "ki_range", "kd_range")
    @classmethod
    def _range_is_the_right_way_up(cls, ends: tuple[float, float]) -> tuple[float, float]:
        if ends[0] > ends[1]:
            raise ValueError(f"the least gain comes first, not {ends[0]} before {ends[1]}")
        return ends


class ControllerState(NamedTuple):
    """The controller's state; errors and measurements in the unit of the controlled quantity.

    Parameters
    ----------
    drive_voltage_v
        The last drive [V], as it was clamped.
    error
        The last error.
    measured
        The last measured value.
    measured_rate
        Its filtered rate, per second.
    error_rate
        The filtered rate of the error, per second.
    rates_known
        False after a hold: the last measurement is then too old to make a rate with.
    """

    drive_voltage_v: float
    error: float
    measured: float
    measured_rate: float
    error_rate: float
    rates_known: bool


class StepResult(NamedTuple):
    """Result of one tick of the controller: command, next state and the gains that were used.

    Parameters
    ----------
    state
        The next state.
    drive_voltage_v
        The drive to command [V].
    kp
        K_p that was used.
    ki
        K_I that was used [1/s].
    kd
        K_D that was used [s].
    """

    state: ControllerState
    drive_voltage_v: float
    kp: float
    ki: float
    kd: float


class FuzzyPid:
    """Fuzzy-tuned PID with drive limits.

    It holds no state: ``start`` makes one, ``step`` and ``hold`` return the next. Building it compiles the tick (or
    loads it from the cache), so that no step waits for it.

    Parameters
    ----------
    settings
        Gains, scales and the name of the rule base.
    limits
        The range of the drive.
    rule_base
        A rule base already loaded; the one that the settings name if None.

    Raises
    ------
    CallerError
        If the settings name no known rule base.
    """

    def __init__(
        self,
        settings: FuzzyPidSettings,
        limits: DriveLimits,
        rule_base: RuleBase | None = None,
    ) -> None:
        """Load the rule base and compile the tick."""
        from musclewire.controllers import _kernels as kernels

        self.settings = settings
        self.limits = limits
        self.rule_base = rule_base or load_rule_base(self.settings.rule_base)
        self._tick: Any = kernels.tick
        self._setting_row = packed_settings(self.settings, limits)
        self._rule_row = packed_rules(self.rule_base)
        self.step(self.start(limits.sense_voltage_v, 0.0, 0.0), 0.0, 0.0, 1.0)

    def __repr__(self) -> str:
        """Show limits, settings and rule base."""
        return f"FuzzyPid({self.settings!r}, {self.limits!r}, rule_base={self.rule_base.name!r})"

    def start(self, drive_voltage_v: float, measured: float, target: float) -> ControllerState:
        """Return the state that takes over from a drive already applied, without a jump.

        A first step with the same measurement and target changes the drive by its integral part only.

        Parameters
        ----------
        drive_voltage_v
            The drive [V]; one outside the limits is brought to the nearest one.
        measured
            The measured value.
        target
            The target, in the same unit.

        Returns
        -------
        The state.

        Raises
        ------
        NumericsError
            If an input is not finite.
        """
        if not (math.isfinite(drive_voltage_v) and math.isfinite(measured) and math.isfinite(target)):
            raise NumericsError(
                f"cannot start the controller from drive {drive_voltage_v} V, measured {measured}, "
                f"target {target}: wait for a valid measurement"
            )
        drive = self.limits.clamp(float(drive_voltage_v))
        return ControllerState(drive, float(target) - float(measured), float(measured), 0.0, 0.0, True)

    def step(self, state: ControllerState, target: float, measured: float, dt_s: float) -> StepResult:
        """Advance by one tick.

        Parameters
        ----------
        state
            The state before.
        target
            The target, in the unit of ``error_unit``.
        measured
            The measured value, in the same unit.
        dt_s
            Time since the last step [s], above 0.

        Returns
        -------
        The next state, the drive and the gains.

        Raises
        ------
        NumericsError
            If an input is not finite, or so large that the result is not; call :meth:`hold` instead.
        CallerError
            If ``dt_s`` is not above zero.

        References
        ----------
        Lan and Fan 2010, Fig. 10 and Eq. 6, in velocity form (see the module).
        """
        target, measured, dt_s = float(target), float(measured), float(dt_s)
        if not (math.isfinite(measured) and math.isfinite(target) and math.isfinite(dt_s)):
            raise NumericsError(
                f"controller step with target {target}, measured {measured}, dt_s {dt_s}: "
                "every input must be finite; hold the drive until the measurement is back"
            )
        if dt_s <= 0.0:
            raise CallerError(f"controller step with dt_s {dt_s}: the time since the last step must be above zero")
        drive, error, measured, measured_rate, error_rate, known, kp, ki, kd = self._tick(
            tuple(state), target, measured, dt_s, self._setting_row, self._rule_row
        )
        if not math.isfinite(measured_rate + error_rate):
            raise NumericsError(f"controller step with target {target}, measured {measured} overflows; check the units")
        next_state = ControllerState(drive, error, measured, measured_rate, error_rate, known)
        return StepResult(next_state, drive, kp, ki, kd)

    def hold(self, state: ControllerState) -> ControllerState:
        """Return the state for a tick without a measurement: same drive, rates forgotten.

        Parameters
        ----------
        state
            The state before.

        Returns
        -------
        The state after.
        """
        return state._replace(measured_rate=0.0, error_rate=0.0, rates_known=False)


class FuzzyPidController:
    """The fuzzy-tuned PID as a loop's controller (``controllers.Controller``).

    Its state is the drive it took over until the first estimate, and the law's state from then on.

    Parameters
    ----------
    law
        The law with its settings, limits and rule base.
    """

    columns = GAIN_COLUMNS

    def __init__(self, law: FuzzyPid) -> None:
        """Control by a law."""
        self.law = law
        self.settings, self.limits = law.settings, law.limits

    def start(self, drive_voltage_v: float) -> Drive:
        """Return the state before the first estimate: the applied drive [V], within the limits."""
        return Drive(self.limits.clamp(float(drive_voltage_v)))

    def step(
        self, state: Drive | ControllerState, target: float, estimate: QuantityEstimate, dt_s: float
    ) -> ControlStep:
        """Return the law's drive for an estimate; without current the last one, and no gains."""
        if estimate.reason is NO_CURRENT:
            if isinstance(state, Drive):
                return ControlStep(state, state, (0.0, 0.0, 0.0))
            held = self.law.hold(state)
            return ControlStep(Drive(held.drive_voltage_v), held, (0.0, 0.0, 0.0))
        if isinstance(state, Drive):
            state = self.law.start(state.voltage_v, estimate.value, target)
        following, drive_voltage_v, kp, ki, kd = self.law.step(state, target, estimate.value, dt_s)
        return ControlStep(Drive(drive_voltage_v), following, (kp, ki, kd))

    def compiled_tick(self, drive_voltage_v: float) -> CompiledTick | None:
        """Return ``step`` as a compiled function."""
        from musclewire.controllers import _compiled_ticks as compiled_ticks

        if type(self.law) is not FuzzyPid:  # another law has another step
            return None
        state = np.zeros(1, compiled_ticks.FUZZY_PID_STATE)
        state["drive_voltage_v"] = self.limits.clamp(float(drive_voltage_v))
        packed = (packed_settings(self.settings, self.limits), packed_rules(self.law.rule_base))
        constants = np.concatenate([row.view(np.float64) for row in packed])
        return CompiledTick(compiled_ticks.fuzzy_tick, constants, state.view(np.float64))


def fuzzy_pid_controller(setup: ControllerSetup) -> FuzzyPidController:
    """Return the fuzzy-tuned PID for a loop.

    Parameters
    ----------
    setup
        Limits, error unit, and ``FuzzyPidSettings`` or None. Settings that name an error unit keep it.

    Returns
    -------
    The controller, compiled.

    Raises
    ------
    CallerError
        If the settings are another controller's.
    """
    settings = with_error_unit(settings_of_kind(setup, FuzzyPidSettings), setup.error_unit)
    return FuzzyPidController(FuzzyPid(settings, setup.limits))


def with_error_unit(settings: FuzzyPidSettings, error_unit: float) -> FuzzyPidSettings:
    """Return settings with an error unit, unless they name one themselves or it is strain's, which is their default."""
    if error_unit == PERCENT_STRAIN or "error_unit" in settings.model_fields_set:
        return settings
    return settings.model_copy(update={"error_unit": error_unit})


def packed_settings(settings: FuzzyPidSettings, limits: DriveLimits) -> NDArray[np.void]:
    """Return settings and limits as the structured array of length 1 that the tick reads (``kernels.SETTINGS``)."""
    from musclewire.controllers import _kernels as kernels

    packed = np.zeros(1, kernels.SETTINGS)
    row = packed[0]
    for gain in ("kp", "ki", "kd"):
        row[f"{gain}_minimum"], row[f"{gain}_maximum"] = getattr(settings, f"{gain}_range")
    for name in ("input_scale", "error_unit", "error_range", "change_range", "derivative_filter_s"):
        row[name] = getattr(settings, name)
    row["sense_voltage_v"], row["maximum_voltage_v"] = limits.sense_voltage_v, limits.maximum_voltage_v
    return packed
