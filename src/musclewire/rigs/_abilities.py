"""Optional abilities of rigs: the one place in which they are looked up, each found as an object or None."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from musclewire.controllers import ProtectionLimits
from musclewire.errors import CallerError
from musclewire.rigs._device import (
    AdjustableClock,
    HasAdjustableClock,
    HasOnBoardLoop,
    HasStage,
    HasTendonStage,
    HasTrueState,
)
from musclewire.rigs._guarded import GuardedRig
from musclewire.rigs._protocol import Rig

__all__ = [
    "ExchangeTimes",
    "adjustable_clock_of",
    "exchange_times_of",
    "keeps_real_time",
    "on_board_loop_of",
    "protection_limits_of",
    "required_true_state",
    "stage_of",
    "tendon_stage_of",
    "true_state_of",
]


@runtime_checkable
class ExchangeTimes(Protocol):
    """A rig that notes when its drive went out and when its sample was there (``time.perf_counter_ns``)."""

    drive_at_ns: int
    sample_at_ns: int


@runtime_checkable
class HasProtection(Protocol):
    """A rig with protection limits."""

    @property
    def protection_limits(self) -> ProtectionLimits:
        """The limits that the protection table applies."""
        ...


class GuardedStage:
    """The stage of a guarded device: after a move the protection compares no reading with one before."""

    def __init__(self, rig: GuardedRig, stage: HasStage) -> None:
        """Keep rig and stage; no move yet."""
        self._rig, self._stage = rig, stage

    def set_pretension(self, pretension_n: float) -> None:
        """Move the stage until the cold wire carries a force [N], as ``HasStage`` says."""
        self._stage.set_pretension(pretension_n)
        self._rig.forget_readings()


class GuardedTendonStage:
    """The finger's stage of a guarded device, after whose moves no reading is compared with one before either."""

    def __init__(self, rig: GuardedRig, stage: HasTendonStage) -> None:
        """Keep rig and stage; no move yet."""
        self._rig, self._stage = rig, stage

    def set_tendon_slack(self, slack_m: float) -> None:
        """Give the tendon this slack [m], as ``HasTendonStage`` says."""
        self._stage.set_tendon_slack(slack_m)
        self._rig.forget_readings()


def able(rig: Rig) -> object:
    """Return the object with the abilities of a rig: the guarded device, or a rig of another class itself."""
    return rig.device if isinstance(rig, GuardedRig) else rig


def stage_of(rig: Rig) -> HasStage | None:
    """Return the stage that sets the pretension of a rig's wire.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    The stage; None if software cannot move one.
    """
    found = able(rig)
    if not isinstance(found, HasStage):
        return None
    return GuardedStage(rig, found) if isinstance(rig, GuardedRig) else found


def tendon_stage_of(rig: Rig) -> HasTendonStage | None:
    """Return the stage that carries a rig's finger.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    The stage; None if software cannot move one.
    """
    found = able(rig)
    if not isinstance(found, HasTendonStage):
        return None
    return GuardedTendonStage(rig, found) if isinstance(rig, GuardedRig) else found


def true_state_of(rig: Rig) -> HasTrueState | None:
    """Return the true state of a simulated rig, for judging a result; never for an estimator.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    An object with the true state at any time, None for a rig that is not simulated.
    """
    found = able(rig)
    return found if isinstance(found, HasTrueState) else None


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
    found = true_state_of(rig)
    if found is None:
        raise CallerError("only a simulated rig knows its wire's true state, and this one is not: open a simulated one")
    return found


def adjustable_clock_of(rig: Rig) -> AdjustableClock | None:
    """Return the clock of a simulated rig that keeps pace with the computer's and may run faster or slower.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    The clock; None for hardware, whose clock is its own, and for a rig without a clock.
    """
    found = able(rig)
    return found.adjustable_clock if isinstance(found, HasAdjustableClock) else None


def keeps_real_time(rig: Rig) -> bool:
    """Return whether a second of a rig's samples is a second of the computer's clock.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    True for hardware and for a simulation that is paced in real time, at this moment.
    """
    clock = adjustable_clock_of(rig)
    return rig.paced and (clock is None or clock.speed == 1.0)


def on_board_loop_of(rig: Rig) -> HasOnBoardLoop | None:
    """Return the closed loop on a rig's device.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    The loop with its model's checksum and its last estimate, None if the device follows no targets.
    """
    found = able(rig)
    return found if isinstance(found, HasOnBoardLoop) else None


def protection_limits_of(rig: Rig) -> ProtectionLimits | None:
    """Return the limits that a rig is protected by.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    The limits, None for a rig without a protection table.
    """
    return rig.protection_limits if isinstance(rig, HasProtection) else None


def exchange_times_of(rig: Rig) -> ExchangeTimes | None:
    """Return the times of a rig's exchanges.

    Parameters
    ----------
    rig
        Any rig, open.

    Returns
    -------
    The rig itself, None if it notes none and the caller has to look at the clock.
    """
    return rig if isinstance(rig, ExchangeTimes) else None
