"""Targets over time, from what a page asks for."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.controllers import Reference, SteeredReference, sampled_reference, staircase
from musclewire.errors import CallerError
from musclewire.experiment import staircase_within
from musclewire.extras.live import _messages as messages
from musclewire.sensing import SensingModel

# A drawn path may last this long [s].
MAX_DURATION_S = 3600.0


class FollowedReference(NamedTuple):
    """A reference, and the same one if it is steered."""

    reference: Reference
    steered: SteeredReference | None = None


def reference_of(asked: object, model: SensingModel, sample_period_s: float) -> FollowedReference:
    """Return the reference of a command, in the model's quantity. Raises CallerError for an impossible one."""
    if isinstance(asked, messages.Steer):
        low, high = model.quantity_min, model.quantity_max
        steered = SteeredReference(0.5 * (low + high) if asked.start is None else asked.start, lowest=low, highest=high)
        return FollowedReference(steered, steered)
    if isinstance(asked, messages.Steps):
        return FollowedReference(staircase_of(asked, model))
    if isinstance(asked, messages.Sine):
        return FollowedReference(sine_of(asked, sample_period_s))
    assert isinstance(asked, messages.DrawnPath)
    return FollowedReference(path_of(asked, sample_period_s))


def staircase_of(asked: messages.Steps, model: SensingModel) -> Reference:
    """Return a staircase; the paper's if no level is given."""
    levels = (asked.start, asked.stop, asked.step)
    if all(level is None for level in levels):
        return staircase_within(model)
    if any(level is None for level in levels):
        raise CallerError("a staircase needs its start, its stop and its step: give all three, or none for the paper's")
    start, stop, step = (float(level or 0.0) for level in levels)
    return staircase(start, stop, step, asked.hold_s)


def sine_of(asked: messages.Sine, sample_period_s: float) -> Reference:
    """Return a sine, sampled as the rig samples; it begins at its middle and rises."""
    duration_s = asked.cycles * asked.period_s
    require_bounded(duration_s)
    time_s = np.arange(0.0, duration_s + 0.5 * sample_period_s, sample_period_s)
    return sampled_reference(time_s, asked.middle + asked.amplitude * np.sin(2.0 * np.pi * time_s / asked.period_s))


def path_of(asked: messages.DrawnPath, sample_period_s: float) -> Reference:
    """Return a drawn path, straight between its points. Raises CallerError for points that are not in order."""
    points_s, targets = np.asarray(asked.time_s), np.asarray(asked.target)
    if points_s.shape != targets.shape or points_s.size < 2 or (np.diff(points_s) <= 0.0).any():
        raise CallerError("a path needs two points or more, one target for each time, and times that increase")
    require_bounded(float(points_s[-1] - points_s[0]))
    time_s = np.arange(0.0, points_s[-1] - points_s[0] + 0.5 * sample_period_s, sample_period_s)
    return sampled_reference(time_s, np.interp(time_s + points_s[0], points_s, targets))


def require_bounded(duration_s: float) -> None:
    """Raise CallerError for a reference that lasts for more than an hour."""
    if duration_s > MAX_DURATION_S:
        raise CallerError(f"the reference lasts {duration_s:g} s: an hour at most, so that no wire heats forgotten")
