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
- A missing measurement is bridged: the drive stays, the rates are forgotten. The next step still
  sees the whole change of the error since, so its proportional part catches up, while its derivative starts
  from rest.

The fuzzy ratios only choose gains inside their ranges, and in the velocity form a gain multiplies an
increment, so a change of gains does not move the drive by itself.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from musclewire.controllers._controller import PERCENT_STRAIN, ControllerSetup, settings_of_kind, step_error
from musclewire.controllers._drive_limits import DriveLimits
from musclewire.controllers._fuzzy import packed_rules
from musclewire.controllers._rules import DEFAULT_RULE_BASE, RuleBase, load_rule_base
from musclewire.controllers._schema import StrictModel
from musclewire.signals import CompiledTick, ControlStep, Drive, QuantityEstimate

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

    of_controller: ClassVar[str] = "fuzzy-pid"
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


class FuzzyPidController:
    """Fuzzy-tuned PID with drive limits, as a loop's controller; its state is in the order of ``PidState``.

    References
    ----------
    Lan and Fan 2010, Fig. 10 and Eq. 6, in velocity form (see the module).
    """

    columns = GAIN_COLUMNS

    def __init__(self, settings: FuzzyPidSettings, limits: DriveLimits, rule_base: RuleBase | None = None) -> None:
        """Load the rule base and compile the tick."""
        from musclewire.controllers import _kernels as kernels

        self.settings, self.limits = settings, limits
        self.rule_base = rule_base or load_rule_base(settings.rule_base)
        self._constants = packed_constants(settings, limits, self.rule_base)
        self._step: Any = kernels.fuzzy_pid_step
        self._tick: Any = kernels.fuzzy_tick
        self.step(self.start(limits.sense_voltage_v), 0.0, QuantityEstimate(0.0, 0.0, True), 1.0)

    def __repr__(self) -> str:
        """Show limits, settings and rule base."""
        return f"FuzzyPidController({self.settings!r}, {self.limits!r}, rule_base={self.rule_base.name!r})"

    def start(self, drive_voltage_v: float) -> tuple[float, ...]:
        """Return the state at the applied drive within limits; a first step changes it by its integral part."""
        return (0.0, self.limits.clamp(float(drive_voltage_v)), 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, state: tuple[float, ...], target: float, estimate: QuantityEstimate, dt_s: float) -> ControlStep:
        """Return the drive for an estimate, and the gains used; without current the last drive, and no gains."""
        # Any other type than float would be compiled now, with the wire driven.
        after, failed, gains = self._step(
            state, float(target), float(estimate.value), float(estimate.reason), float(dt_s), self._constants
        )
        if failed:
            raise step_error(target, estimate.value, dt_s)
        return ControlStep(Drive(after[1]), after, gains)

    def rule_inputs(self, state: tuple[float, ...]) -> tuple[float, float]:
        """Return the inputs of the rules that a step left in its state: the error and its rate, each over its range."""
        from musclewire.controllers import _kernels as kernels

        after = kernels.PidState(*state)
        found: tuple[float, float] = kernels.rule_inputs(self._constants, after.error, after.error_rate)
        return found

    def compiled_tick(self, drive_voltage_v: float) -> CompiledTick:
        """Return ``step`` on arrays, for loops in compiled code."""
        return CompiledTick(self._tick, self._constants.view(np.float64), np.array(self.start(drive_voltage_v)))


def fuzzy_pid_controller(setup: ControllerSetup) -> FuzzyPidController:
    """Return the fuzzy-tuned PID for a loop; settings that name an error unit keep it."""
    settings = with_error_unit(settings_of_kind(setup, FuzzyPidSettings), setup.error_unit)
    return FuzzyPidController(settings, setup.limits)


def with_error_unit(settings: FuzzyPidSettings, error_unit: float) -> FuzzyPidSettings:
    """Return settings with an error unit, unless they name one themselves or it is strain's, which is their default."""
    if error_unit == PERCENT_STRAIN or "error_unit" in settings.model_fields_set:
        return settings
    return settings.model_copy(update={"error_unit": error_unit})


def packed_constants(settings: FuzzyPidSettings, limits: DriveLimits, rule_base: RuleBase) -> NDArray[np.void]:
    """Return rule base, settings and limits as the structured array of length 1 of the tick (``kernels.FUZZY_PID``)."""
    packed = packed_rules(rule_base)
    row = packed[0]
    for gain in ("kp", "ki", "kd"):
        row[f"{gain}_minimum"], row[f"{gain}_maximum"] = getattr(settings, f"{gain}_range")
    for name in ("input_scale", "error_unit", "error_range", "change_range", "derivative_filter_s"):
        row[name] = getattr(settings, name)
    row["sense_voltage_v"], row["maximum_voltage_v"] = limits.sense_voltage_v, limits.maximum_voltage_v
    return packed
