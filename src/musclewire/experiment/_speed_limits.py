"""A reference before the wire is heated: the staircase within a model's range, its targets, and its speed limits."""

from __future__ import annotations

import math
from typing import Any

from musclewire.controllers import FeedforwardSettings, Reference, Staircase, SteeredReference, staircase
from musclewire.errors import CallerError, RecordingError, an_object
from musclewire.experiment._run import what_protects
from musclewire.identify import FastestWay, SpeedLimits, speed_limits_of
from musclewire.rigs import Rig
from musclewire.sensing import SHOWN_AS, KnownSpring, SensingModel, force_model
from musclewire.signals import RunFacts

# The paper's staircase goes to 3.0 % where its wire reaches 3.6 %, from half of that, in five steps.
TOP_FRACTION = 0.84
STEPS = 5
DIGITS = 2


def staircase_within(model: SensingModel) -> Staircase:
    """Return the paper's staircase for strain; for displacement and force, from half of a round top in five steps.

    The top is 84 % of the model's maximum, rounded down to two digits. Raises CallerError if half of it is below the
    model's minimum.
    """
    if model.quantity == "strain":
        return staircase()
    top = TOP_FRACTION * model.quantity_max
    unit = 10.0 ** (math.floor(math.log10(top)) - DIGITS + 1)
    top = unit * math.floor(top / unit)
    if 0.5 * top < model.quantity_min:
        factor, name = SHOWN_AS[model.quantity]
        raise CallerError(
            f"no staircase fits: its first step would be {factor * 0.5 * top:.4g} {name}, and the model senses "
            f"{model.quantity} from {factor * model.quantity_min:.4g} {name}: give a reference of your own"
        )
    return staircase(0.5 * top, top, 0.5 * top / STEPS)


def checked_reference(model: SensingModel, reference: Reference | None) -> Reference:
    """Return a reference, by default the staircase within the model. Raises CallerError for what is no reference."""
    if reference is not None and not hasattr(reference, "targets_at"):
        raise CallerError(
            "a reference is made by staircase(start, stop, increment) or sampled_reference(time_s, target), not "
            f"{an_object(reference)}"
        )
    return staircase_within(model) if reference is None else reference


def check_targets(model: SensingModel, reference: Reference, sample_period_s: float, shift: float = 0.0) -> None:
    """Raise CallerError if a reference leaves the range in which the model senses; it is lower by ``shift`` today."""
    if reference.duration_s < sample_period_s:
        raise CallerError(
            f"the reference lasts {reference.duration_s:g} s, less than one sample of {sample_period_s:g} s: "
            "its last row states when it ends, give one later"
        )
    low, high = range_of(reference, sample_period_s)
    margin = 1e-3 * (model.quantity_max - model.quantity_min)
    least, most = model.quantity_min - shift, model.quantity_max - shift
    if low < least - margin or high > most + margin:
        factor, unit = SHOWN_AS[model.quantity]
        raise CallerError(
            f"the reference goes from {factor * low:.4g} to {factor * high:.4g} {unit}, but this model senses "
            f"{model.quantity} only from {factor * least:.4g} to {factor * most:.4g} {unit}"
            f"{' from the zero of this room' if shift else ''}: choose targets inside"
        )


def range_of(reference: Reference, sample_period_s: float) -> tuple[float, float]:
    """Return the lowest and the highest target of a reference; of a steered one, those that it allows."""
    if isinstance(reference, SteeredReference):
        return reference.lowest, reference.highest
    times = [index * sample_period_s for index in range(round(reference.duration_s / sample_period_s) + 1)]
    targets = reference.targets_at(times)
    return float(targets.min()), float(targets.max())


def speed_limits(
    rig: Rig,
    model: SensingModel,
    reference: Reference | None = None,
    *,
    settings: Any = None,
    load: KnownSpring | None = None,
    from_cold: bool = False,
) -> SpeedLimits:
    """Say beforehand where a reference is faster than the wire heats or cools. Nothing is driven.

    The wire follows as closely as its heat balance lets it: at the maximum voltage below its target, at the sense
    voltage above it, along the branches of its slow loop. Real loops do that at best. It begins at the first target,
    as after an approach; still air is assumed.

    Parameters
    ----------
    rig
        The rig, open: its voltages are those of its protection.
    model
        The model of its wire, with the power through its slow loop and its heat balance, as ``fit`` keeps them.
    reference
        The targets over time, in the model's quantity; the paper's staircase if None.
    settings
        ``FeedforwardSettings`` of ``tune`` for the same quantity, whose plant then counts; anything else takes the
        plant from the model.
    load
        A known spring: then the targets are forces.
    from_cold
        Whether a staircase begins with a cold wire: then ``supply`` says which of its steps the supply makes late.

    Returns
    -------
    What the wire cannot follow (``findings``), the amplitude possible (``possible_amplitude``), what would help
    (``help``), and ``warnings`` in words.

    Raises
    ------
    CallerError
        If a target is outside the model's range.
    RecordingError
        If the model has no power through its loop, or the rig does not state its limits.

    References
    ----------
    Heat balance and branches: ``musclewire.controllers._known_wire``.

    Examples
    --------
    >>> import numpy as np
    >>> import musclewire as mw
    >>> time_s = np.arange(0.0, 10.0, 0.05)
    >>> fast = mw.sampled_reference(time_s, 0.022 + 0.008 * np.sin(2 * np.pi * 1.0 * time_s))
    >>> with mw.open_rig("simulated") as rig:
    ...     model = mw.fit(mw.characterize(rig))
    ...     limits = mw.speed_limits(rig, model, fast)
    >>> limits.findings[0].direction, limits.possible_amplitude < limits.asked_amplitude
    ('cooling', True)
    """
    if load is not None:
        model = force_model(model, load.stiffness_n_per_m, rig.leg_length_m)
    chosen = checked_reference(model, reference)
    check_targets(model, chosen, rig.sample_period_s)
    return speed_limits_of(model, chosen, *speed_facts(rig, model, settings), from_cold=from_cold)


def speed_facts(rig: Rig, model: SensingModel, settings: Any) -> tuple[RunFacts, FeedforwardSettings | None]:
    """Return what of a rig its wire's speed follows from, and the settings, if they are this quantity's plant."""
    tuned = isinstance(settings, FeedforwardSettings) and settings.quantity == model.quantity
    return RunFacts({**rig.metadata(), **what_protects(rig)}, "the rig"), settings if tuned else None


def fastest_way(rig: Rig, model: SensingModel, settings: Any, *, from_cold: bool) -> FastestWay | None:
    """Return how fast the wire is at best, sample by sample; None if model or rig do not state what it follows from."""
    try:
        return FastestWay(model, *speed_facts(rig, model, settings), from_cold=from_cold)
    except RecordingError:
        return None


def speed_metadata(
    rig: Rig, model: SensingModel, reference: Reference, settings: Any, *, from_cold: bool = False
) -> dict[str, str]:
    """Return a reference's warnings under ``speed_limits``, or what is not stated; nothing if it can be followed."""
    if isinstance(reference, SteeredReference):
        return {}
    try:
        warnings = speed_limits(rig, model, reference, settings=settings, from_cold=from_cold).warnings
    except RecordingError as error:
        return {"speed_limits": f"not known: {error}"}
    return {"speed_limits": "; ".join(warnings)} if warnings else {}
