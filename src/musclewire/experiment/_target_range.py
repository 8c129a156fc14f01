"""Whether the targets of a reference lie within what a model senses."""

from __future__ import annotations

from musclewire.controllers import Reference, SteeredReference
from musclewire.errors import CallerError
from musclewire.sensing import SHOWN_AS, SensingModel


def check_targets(model: SensingModel, reference: Reference, sample_period_s: float) -> None:
    """Raise CallerError if a reference leaves the range in which the model senses."""
    if reference.duration_s < sample_period_s:
        raise CallerError(
            f"the reference lasts {reference.duration_s:g} s, less than one sample of {sample_period_s:g} s: "
            "its last row states when it ends, give one later"
        )
    low, high = range_of(reference, sample_period_s)
    margin = 1e-3 * (model.quantity_max - model.quantity_min)
    if low < model.quantity_min - margin or high > model.quantity_max + margin:
        factor, unit = SHOWN_AS[model.quantity]
        raise CallerError(
            f"the reference goes from {factor * low:.4g} to {factor * high:.4g} {unit}, but this model senses "
            f"{model.quantity} only from {factor * model.quantity_min:.4g} to {factor * model.quantity_max:.4g} "
            f"{unit}: choose targets inside"
        )


def range_of(reference: Reference, sample_period_s: float) -> tuple[float, float]:
    """Return the lowest and the highest target of a reference; of a steered one, those that it allows."""
    if isinstance(reference, SteeredReference):
        return reference.lowest, reference.highest
    times = [index * sample_period_s for index in range(round(reference.duration_s / sample_period_s) + 1)]
    targets = reference.targets_at(times)
    return float(targets.min()), float(targets.max())
