"""Optional abilities of rigs: the one place in which they are looked up, each found as an object or None."""

from __future__ import annotations

from typing import Any, TypeVar

from musclewire.errors import CallerError
from musclewire.rigs._device import HasStage, HasTendonStage, HasTrueState
from musclewire.rigs._guarded import GuardedRig, Rig
from musclewire.rigs._simulation_clock import SimulationClock

AbilityT = TypeVar("AbilityT")


class GuardedStages:
    """The stages of a guarded device: after a move the protection compares no reading with one before."""

    def __init__(self, rig: GuardedRig, stage: Any) -> None:
        """Keep rig and stage; no move yet."""
        self._rig, self._stage = rig, stage

    def set_pretension(self, pretension_n: float) -> None:
        """Move the stage until the cold wire carries a force [N], as ``HasStage`` says."""
        self._stage.set_pretension(pretension_n)
        self._rig.forget_readings()

    def set_tendon_slack(self, slack_m: float) -> None:
        """Give the tendon this slack [m], as ``HasTendonStage`` says."""
        self._stage.set_tendon_slack(slack_m)
        self._rig.forget_readings()


def ability(rig: Rig, kind: type[AbilityT]) -> AbilityT | None:
    """Return what a rig, or the device that it guards, can do beyond exchanging samples; None if it cannot.

    ``kind`` is one of the protocols of :mod:`musclewire.rigs` whose names begin with "Has". What ``HasTrueState`` says
    is to judge a result and never for an estimator.
    """
    if not isinstance(rig.device, kind):
        return None
    able: Any = GuardedStages(rig, rig.device) if kind in (HasStage, HasTendonStage) else rig.device
    return able  # type: ignore[no-any-return]


def required_true_state(rig: Rig) -> HasTrueState:
    """Return the true state of a simulated rig.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    An object with the true state at any time.

    Raises
    ------
    CallerError
        If the rig is not simulated.
    """
    found = ability(rig, HasTrueState)
    if found is None:
        raise CallerError("only a simulated rig knows its wire's true state, and this one is not: open a simulated one")
    return found


def adjustable_clock_of(rig: Rig) -> SimulationClock | None:
    """Return the clock of a simulated rig that keeps pace with the computer's and may run faster or slower.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    The clock; None for hardware, whose clock is its own, and for a rig without a clock.
    """
    clock = getattr(rig.device, "adjustable_clock", None)
    return clock if isinstance(clock, SimulationClock) else None


def keeps_real_time(rig: Rig) -> bool:
    """Return whether a second of an open rig's samples is one of the computer's clock: hardware, or paced so now."""
    clock = adjustable_clock_of(rig)
    return rig.paced and (clock is None or clock.speed == 1.0)
