"""The home move: a sweep at a known load by which a model is brought up to the wire of today, without any sensor."""

from __future__ import annotations

from typing import Unpack

from musclewire.errors import CallerError, FitRejectedError, RecordingError
from musclewire.experiment._calm_air import heed_air
from musclewire.experiment._home_sweep import HomeSweep, SweepPlan
from musclewire.experiment._run import RunOptions, run_on_rig
from musclewire.identify import Homing, check_made_for, homed_model, loop_of, require_load
from musclewire.rigs import Rig, refuse_no_rig
from musclewire.sensing import SensingModel
from musclewire.signals import MetadataValue

# Springs that differ by less are one spring.
SAME_SPRING = 0.02


def home(
    rig: Rig,
    model: SensingModel,
    *,
    load_n: float | None = None,
    ambient_k: float | None = None,
    cycles: float | None = None,
    **run: Unpack[RunOptions],
) -> Homing:
    """Heat the wire once just beyond its transformation, and bring its model up to date.

    A sweep of 20 to 40 s finds by how much the wire's resistance has been scaled or offset and its transformation
    temperatures have shifted since the model was made. The model is corrected where B and C show that it is the
    resistance that has changed: C then moves nearly as much as B, and under another load less than half as much.
    Where B has not moved, the model keeps its curve; all else is refused, unless the load is known.

    Parameters
    ----------
    rig
        The rig, open; it is driven.
    model
        The model, fitted to a recording with voltages.
    load_n
        Force of the cold wire now [N]: your word, or that of a stage that sets it, that the load is that of the
        characterization. What a rig file states is no such word: a load changes without it.
    ambient_k
        Measured temperature of the air [K]; that of the rig's own thermometer, if it has one, if None. With it the
        shift of the transformation is known to 3 K instead of 9 K, and a changed load is noticed more surely.
    cycles
        Cycles that the wire has made since the characterization, if they were counted; kept in the model.
    **run
        ``path`` of the recorded sweep, ``overwrite`` one that exists, ``on_sample`` called with every recorded row; it
        may raise to stop the run, ``until`` asked after each whether the run is to end now.

    Returns
    -------
    The model of today, what was found with its uncertainty, and notes on what was not seen.

    Raises
    ------
    CallerError
        For a model of another wire or load, or one without the power of its loop.
    FitRejectedError
        If the sweep is incomplete, began warm, or shows what a changed load explains as well as a changed wire, or what
        no wire does; the model is as it was.
    RigError
        If the rig failed or was tripped; it carries the partial recording as ``.recording``.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated") as rig:
    ...     model = mw.fit(mw.characterize(rig))
    ...     found = mw.home(rig, model)
    >>> found.home.corrected  # the wire has not changed
    False
    """
    refuse_no_rig(rig)
    known = rig.metadata()
    check_made_for(model, known)
    heed_air(rig, model)
    stated_n = known.get("pretension_n") if load_n is None else load_n
    assumed_n = require_load(model, float(stated_n) if isinstance(stated_n, int | float) else None)
    require_spring(model, known.get("spring_stiffness_n_per_m"))
    plan = plan_for(rig, model)
    sweep = HomeSweep(rig, plan)
    metadata: dict[str, MetadataValue] = {"experiment": "home move", "assumed_load_n": assumed_n}
    if ambient_k is not None:
        metadata["measured_ambient_k"] = ambient_k
    with rig.holding_back():
        recording = run_on_rig(rig, sweep, plan.duration_s, metadata=metadata, **run)
    try:
        return homed_model(model, recording, load_n=load_n, ambient_k=ambient_k, cycles=cycles)
    except (RecordingError, FitRejectedError) as error:
        limit = f" ({sweep.stopped_by})" if sweep.stopped_by else ""
        raise FitRejectedError("no home move, the model is as it was: " + str(error) + limit) from None


def plan_for(rig: Rig, model: SensingModel) -> SweepPlan:
    """Return the plan of a model's home move on a rig. Raises CallerError for a model without its loop's power."""
    loop = loop_of(model)
    span_ohm = model.resistance_max_ohm - model.resistance_min_ohm
    return SweepPlan.for_rig(rig, float(loop.power_w.max()), span_ohm)


def home_duration_s(rig: Rig, model: SensingModel) -> float:
    """Return how long a home move takes [s]. Raises CallerError for a model without its loop's power."""
    return plan_for(rig, model).duration_s


def require_spring(model: SensingModel, stated_n_per_m: MetadataValue) -> None:
    """Raise CallerError if the rig states another spring than the model was characterized on."""
    before = model.wire.get("spring_stiffness_n_per_m")
    if (
        isinstance(before, int | float)
        and isinstance(stated_n_per_m, int | float)
        and abs(stated_n_per_m - before) > SAME_SPRING * before
    ):
        raise CallerError(
            f"the wire pulls {stated_n_per_m:g} N/m and pulled {before:g} N/m at the characterization: make the "
            "home move on the same load, or characterize again on this one"
        )
