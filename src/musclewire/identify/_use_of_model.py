"""What uses a fitted model: the wire it was fitted to, the controller's unit of error, the wire of a user's file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from musclewire.controllers import PERCENT_STRAIN, FeedforwardSettings, Gains
from musclewire.errors import CallerError, argument
from musclewire.identify._recordings import DIVIDED_BY
from musclewire.judge import height_of_b
from musclewire.parameters import Alloy, bench_known_with, is_wire_file, load_alloy, load_bench, load_wire, names
from musclewire.sensing import (
    DEFAULT_ESTIMATOR,
    PAPER_ESTIMATOR,
    KnownSpring,
    SensingModel,
)
from musclewire.signals import MetadataValue, RunFacts
from musclewire.wire import WireConstants, constants_of, measured_grains

# The estimator that reads a wire file, and our own that read none.
OF_A_WIRE_FILE, WITHOUT_WIRE_FILE = "particle-filter", (DEFAULT_ESTIMATOR, PAPER_ESTIMATOR)
# Lengths that differ by less are one length, measured twice.
SAME_LENGTH_FRACTION = 0.005
# Loads and springs that differ by less are one, measured twice.
SAME_LOAD_FRACTION = 0.02
# What of a load a model and a rig may both state, in words and with its unit.
STATED_LOAD = {"pretension_n": ("a pretension", "N"), "spring_stiffness_n_per_m": ("a spring", "N/m")}
# What the whole range of a quantity other than strain counts as, in the controller's unit of percent strain.
RANGE_AS_PERCENT_STRAIN = 3.0
# Where friction reverses, force changes steeply with strain: this multiple of the friction counts as range, or the loop
# chatters.
FRICTION_AS_RANGE = 8.0
# From a command to its effect on the estimate: one sample until it is measured, half a sample of the hold, and half a
# sample of the estimator's filter.
DEAD_SAMPLES = 2.0


def check_wire_file(wire_file: str | Path | None, estimator: Any) -> None:
    """Raise CallerError for a wire file with an estimator of ours, by its name, that reads none."""
    if wire_file is not None and estimator in WITHOUT_WIRE_FILE:
        raise CallerError(
            f"the estimator {estimator} reads no wire file, and particle-filter does: give "
            + argument("estimator", "particle-filter")
            + ", or leave the file out"
        )


def error_unit_for(model: SensingModel, load: KnownSpring | None = None) -> float:
    """Return what of the model's quantity counts as one percent strain: more on a known spring with friction."""
    if model.quantity == "strain":
        return PERCENT_STRAIN
    steep = 0.0 if load is None else FRICTION_AS_RANGE * load.friction_n
    return (model.quantity_max - model.quantity_min + steep) / RANGE_AS_PERCENT_STRAIN


def gains_of(model: SensingModel, sample_period_s: float) -> Gains | None:
    """Return a model's gains at a sample period, None without any. Raises CallerError if what it keeps are no gains."""
    if not model.gains:
        return None
    gains = Gains.read(model.gains, "the gains kept in this model")
    if isinstance(gains.settings, FeedforwardSettings):
        return Gains(gains.controller, plant_at_period(gains.settings, sample_period_s))
    return gains


def plant_at_period(plant: FeedforwardSettings, sample_period_s: float) -> FeedforwardSettings:
    """Return a plant at longer sample periods: with their dead time and, by SIMC, tau_c no shorter than it."""
    dead_s = DEAD_SAMPLES * sample_period_s
    if dead_s <= plant.dead_time_s:
        return plant
    response_s = dead_s + max(dead_s, plant.closed_loop_time_s)
    slower = {
        "dead_time_s": dead_s,
        "closed_loop_time_s": response_s - dead_s,
        "integral_time_s": plant.integral_time_s * response_s / (plant.closed_loop_time_s + plant.dead_time_s),
    }
    return plant.model_copy(update=slower)


def alloy_of(model: SensingModel) -> Alloy:
    """Return the alloy of a model's wire, Flexinol's for a wire that is not known by name."""
    name = str(model.wire.get("wire", ""))
    return load_alloy(load_wire(name).alloy if name in names("wire") else "flexinol")


def check_made_for(
    model: SensingModel, known: Mapping[str, MetadataValue], place: str = "the rig", cure: str = "fit one"
) -> None:
    """Raise CallerError if a model is not for the wire, length or finger that a rig's metadata name.

    Nor is one of resistance over the cold wire's for any rig. ``place`` and ``cure`` are for the message: who names
    another one, and what to do about it.
    """
    require_ohms(model)
    fitted, mounted = model.wire.get("wire"), known.get("wire")
    if fitted and mounted and fitted != mounted:
        raise CallerError(f"this model was fitted to wire {fitted}, {place} has {mounted}: {cure} for this wire")
    was = RunFacts(model.wire, "this model").number_or_none("wire_length_m")
    now = RunFacts(known, "this rig").number_or_none("wire_length_m")
    if was is not None and now is not None and abs(was - now) > SAME_LENGTH_FRACTION * now:
        raise CallerError(
            f"this model was fitted to a wire of {1e3 * was:g} mm, {place} has one of {1e3 * now:g} mm: {cure} "
            "for this length"
        )
    moved, moves = model.wire.get("finger"), known.get("finger")
    if model.quantity == "displacement" and moved and moves and moved != moves:
        raise CallerError(f"this model was fitted to finger {moved}, {place} has {moves}: {cure} for this finger")


def require_ohms(model: SensingModel) -> None:
    """Raise CallerError for a model of resistance over the cold wire's, which only estimates of recordings take."""
    if DIVIDED_BY in model.wire:
        raise CallerError(
            "this model is of resistance over the cold wire's, for estimates of recordings: fit one without "
            + argument("relative_resistance", True)
        )


def other_load(model: SensingModel, known: Mapping[str, MetadataValue]) -> str:
    """Return in words how a rig's load differs from the characterization's, for which alone a model holds; else ""."""
    fitted, stated = RunFacts(model.wire, "this model"), RunFacts(known, "this rig")
    for key, (what, unit) in STATED_LOAD.items():
        was, now = fitted.number_or_none(key), stated.number_or_none(key)
        if was is not None and now is not None and abs(now - was) > SAME_LOAD_FRACTION * was:
            return (
                f"the rig states {what} of {now:g} {unit}, and the model was made at {was:g} {unit}: its estimates are "
                "wrong with this load; characterize and fit with it, or put the other one back"
            )
    return ""


def known_against(model: SensingModel, known: Mapping[str, MetadataValue]) -> dict[str, str]:
    """Return what is known against a loop: ``other_load`` of the rig, and ``model_does_not_hold`` by the fit."""
    bad_fit = "" if model.holds else f"the model does not hold: {model.does_not_hold}"
    reasons = {"other_load": other_load(model, known), "model_does_not_hold": bad_fit}
    return {name: reason for name, reason in reasons.items() if reason}


def load_facts(model: SensingModel, known: Mapping[str, MetadataValue]) -> dict[str, MetadataValue]:
    """Return what a run's recording says of its model and load: what is known against them, and B to compare.

    Besides :func:`known_against` B, C and the rise to B of the slow loop [ohm], with the standard deviation [ohm] with
    which B repeats, or ``b_not_compared``, why there is no B; ``sensed_range``, how far the model senses.
    """
    sensed = {"sensed_range": model.quantity_max - model.quantity_min}
    return {**known_against(model, known), **height_of_b(model), **sensed}


# Numbers of the bench that a rig or a recording may state; they count before those of the wire file.
STATED = ("wire_length_m", "pretension_n", "spring_stiffness_n_per_m", "shunt_resistance_ohm", "guide_friction_n")
# Without these the load is not known.
LOAD = ("spring_stiffness_n_per_m", "pretension_n", "wire_length_m")


def users_wire(path: str | Path, known: Mapping[str, MetadataValue]) -> WireConstants:
    """Return a wire file's constants, cooled under the pretension, on the load that a rig or recording states.

    Length, pretension and stiffness of the metadata count before those in the file. Raises CallerError if it is no wire
    file, or neither it nor the metadata state length, pretension and stiffness of a spring.
    """
    name = str(path)
    if not is_wire_file(name):
        raise CallerError(f"{name} is no wire file: musclewire calibrate -o wire.toml writes one from a recording")
    facts = RunFacts(known, "this rig")
    in_file = {key: item.value for key, item in bench_known_with(name).items()}
    stated = {key: number for key in STATED if (number := facts.number_or_none(key)) is not None}
    lacking = [key for key in LOAD if key not in in_file and key not in stated]
    if lacking or ("load" in known and "spring_stiffness_n_per_m" not in known):
        what = ", ".join(lacking) or f"the stiffness of one spring (the load is {known['load']})"
        raise CallerError(
            f"wire file {name}: neither it nor the rig states {what}: calibrate on this load, or go without the file"
        )
    wire, alloy = load_wire(name), load_alloy(name)
    bench = load_bench("paper").values() | in_file | stated
    leg_m = facts.leg_length_or_none_m
    if leg_m:
        bench["legs"] = round(bench["wire_length_m"] / leg_m)
    return constants_of(alloy.values(), wire.values(), bench, distribution=measured_grains(alloy))
