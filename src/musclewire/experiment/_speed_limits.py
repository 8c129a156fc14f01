"""Speed limits of a reference on a rig, said before the wire is heated."""

from __future__ import annotations

from typing import Any

from musclewire.controllers import FeedforwardSettings, Reference, SteeredReference
from musclewire.errors import RecordingError
from musclewire.experiment._run import what_protects
from musclewire.experiment._staircases import staircase_within
from musclewire.experiment._target_range import check_targets
from musclewire.identify import SpeedLimits, speed_limits_of
from musclewire.rigs import Rig
from musclewire.sensing import KnownSpring, SensingModel, force_model
from musclewire.signals import RunFacts


def speed_limits(
    rig: Rig,
    model: SensingModel,
    reference: Reference | None = None,
    *,
    settings: Any = None,
    load: KnownSpring | None = None,
) -> SpeedLimits:
    """Say beforehand where a reference is faster than the wire heats or cools. Nothing is driven.

    The wire follows as closely as its heat balance lets it: at the maximum voltage below its target, at the sense
    voltage above it, along the branches of its slow loop. Real loops do that at best. It begins at the first target,
    as after an approach; still air is assumed.

    Parameters
    ----------
    rig
        The rig, open: voltages, heat capacity and heat loss are those of its protection.
    model
        The model of its wire, with the power through its slow loop, as ``fit`` keeps it.
    reference
        The targets over time, in the model's quantity; the paper's staircase if None.
    settings
        ``FeedforwardSettings`` of ``tune`` for the same quantity, whose plant then counts; anything else takes the
        plant from the model.
    load
        A known spring: then the targets are forces.

    Returns
    -------
    What the wire cannot follow (``findings``), the amplitude possible (``possible_amplitude``), what would help
    (``help``), and ``warnings`` in words.

    Raises
    ------
    CallerError
        If a target is outside the model's range.
    RecordingError
        If the model has no power through its loop, or the rig does not state its heat balance.

    References
    ----------
    Heat balance and branches: ``musclewire.controllers._feedforward``.

    Examples
    --------
    >>> import numpy as np
    >>> import musclewire as mw
    >>> time_s = np.arange(0.0, 10.0, 0.05)
    >>> fast = mw.sampled_reference(time_s, 0.022 + 0.008 * np.sin(2 * np.pi * 1.0 * time_s))
    >>> with mw.open_rig("simulated") as rig:
    ...     model = mw.fit(mw.characterize(rig))
    ...     limits = mw.speed_limits(rig, model, fast)
    >>> limits.findings[1].direction, limits.possible_amplitude < limits.asked_amplitude
    ('cooling', True)
    """
    if load is not None:
        model = force_model(model, load.stiffness_n_per_m, rig.leg_length_m)
    chosen = staircase_within(model) if reference is None else reference
    check_targets(model, chosen, rig.sample_period_s)
    tuned = isinstance(settings, FeedforwardSettings) and settings.quantity == model.quantity
    plant = settings if tuned else None
    facts = RunFacts({**rig.metadata(), **what_protects(rig)}, "the rig")
    return speed_limits_of(model, chosen, facts, plant)


def speed_metadata(rig: Rig, model: SensingModel, reference: Reference, settings: Any) -> dict[str, str]:
    """Return the warnings of a reference for a run's metadata, under ``speed_limits``; nothing if it can be followed.

    If model or rig do not state what the limits follow from, it says so instead. Of a target that is steered nothing
    can be said beforehand.
    """
    if isinstance(reference, SteeredReference):
        return {}
    try:
        warnings = speed_limits(rig, model, reference, settings=settings).warnings
    except RecordingError as error:
        return {"speed_limits": f"not known: {error}"}
    return {"speed_limits": "; ".join(warnings)} if warnings else {}
