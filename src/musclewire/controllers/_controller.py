"""The interface of controllers: target, estimate and state in; command, state and the numbers to record out.

A controller has no clock, knows no rig and keeps nothing to itself: its only memory is its state, which the loop passes
back. ``tests/contract/test_controller_contract.py`` tests every implementation for this. One that also declares
``compiled_tick(drive_voltage_v)``, a :class:`~musclewire.signals.CompiledTick` of its step with the state of ``start``,
can run in compiled loops (``mw.control_many``).

Another controller is one file with a factory, a ``ControllerFactory``, and a name for it: a line in ``CONTROLLERS``
here, or from outside ``CONTROLLERS.register("name", factory)`` in a script and ``controllers`` in a package's manifest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from musclewire.controllers._drive_limits import DriveLimits
from musclewire.errors import CallerError, NumericsError
from musclewire.registry import Registry
from musclewire.signals import ControlStep, QuantityEstimate, check_columns

PERCENT_STRAIN = 0.01


class Controller(Protocol):
    """Chooses the command of the next sample period."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns that it records, one for each number in ``ControlStep.recorded``."""
        ...

    @property
    def limits(self) -> DriveLimits:
        """The range of the drive voltage [V]; every command is within it."""
        ...

    def start(self, drive_voltage_v: float) -> Any:
        """Return the immutable state that takes over from an applied drive, the nearest limit for one outside."""
        ...

    def step(self, state: Any, target: float, estimate: QuantityEstimate, dt_s: float) -> ControlStep:
        """Return command, next state and the numbers to record; pure: the same arguments give the same answer.

        An estimate without current (``Reason.NO_CURRENT``) is bridged: the command is the last one. Raises
        NumericsError if target or estimate is not finite, CallerError if ``dt_s`` is not above 0.
        """
        ...


@dataclass(frozen=True)
class ControllerSetup:
    """All that a factory may make a controller from.

    Parameters
    ----------
    limits
        Range of the drive voltage [V].
    error_unit
        Amount of the controlled quantity that corresponds to one percent strain, in its SI unit; so one set of gains
        serves strain, displacement and force. The default is that of strain.
    settings
        The controller's own settings, as the caller gave them; None for its defaults.
    """

    limits: DriveLimits
    error_unit: float = PERCENT_STRAIN
    settings: Any = None


ControllerFactory = Callable[[ControllerSetup], Controller]

CONTROLLERS: Registry[ControllerFactory] = Registry(
    "controller",
    "controllers",
    {
        "fuzzy-pid": "musclewire.controllers._fuzzy_pid:fuzzy_pid_controller",
        "inverse-model": "musclewire.controllers._inverse_model:InverseModelController",
        "pid": "musclewire.controllers._pid:pid_controller",
    },
    parts=("limits", "columns", "start", "step"),
    check=check_columns,
)


def settings_of_kind(setup: ControllerSetup, kind: type[Any]) -> Any:
    """Return the settings of a setup, or the defaults of their kind; CallerError for settings of another controller."""
    if setup.settings is None:
        return kind()
    if not isinstance(setup.settings, kind):
        raise CallerError(
            f"the controller needs settings of the kind {kind.__name__}, not {type(setup.settings).__name__}: give "
            "those, or name the controller they belong to"
        )
    return setup.settings


def step_error(target: float, measured: float, dt_s: float) -> CallerError | NumericsError:
    """Return the error of a step whose tick failed: of its caller, or of numbers that no drive follows from."""
    if not dt_s > 0.0:
        return CallerError(f"controller step with dt_s {dt_s}: the time since the last step must be above zero")
    return NumericsError(
        f"controller step with target {target}, measured {measured}, dt_s {dt_s}: every input must be finite "
        "and no rate may overflow; hold the drive until the measurement is back, or check the units"
    )
