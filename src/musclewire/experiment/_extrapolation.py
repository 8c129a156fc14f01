"""Warnings of a run beyond what the alloy's data cover, the vendor's stress, or the temperature of annealing."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from musclewire.parameters import ReachedConditions, ValidityLimits, beyond_validity, section_m2
from musclewire.sensing import noise_level
from musclewire.signals import Recording, RunFacts

# Readings of a load cell are taken for as many standard deviations of its noise less extreme than they are.
NOISES = 4.0


def extrapolation_warnings(recording: Recording) -> tuple[str, ...]:
    """Return a warning for each limit of its alloy that a run exceeds; none for a recording that states no limits."""
    limits = ValidityLimits.stated_in(recording.metadata)
    return beyond_validity(limits, reached_in(recording)) if limits.facts() else ()


def extrapolation_metadata(recording: Recording) -> dict[str, str]:
    """Return the warnings of a run for its own metadata, under ``extrapolation``; nothing within all limits."""
    found = extrapolation_warnings(recording)
    return {"extrapolation": "; ".join(found)} if found else {}


def reached_in(recording: Recording) -> ReachedConditions:
    """Return the stresses and the temperature of a run, as far as instruments and metadata show them.

    Stress is the load cell's force over all sections that it reads together, the pretension's without a load cell.
    """
    section = whole_section_m2(recording.facts)
    temperature = temperature_k(recording)
    if section is None:
        return ReachedConditions(temperature_k=temperature)
    pretension = recording.facts.number_or_none("pretension_n")
    cold = largest = pretension
    if "force_n" in recording and len(recording):
        force = recording["force_n"]
        noise = NOISES * noise_level(force)
        cold, largest = max(float(np.nanmin(force)) + noise, 0.0), float(np.nanmax(force)) - noise
    stresses = [None if force_n is None else force_n / section for force_n in (cold, largest)]
    return ReachedConditions(stresses[0], stresses[1], temperature, section)


def whole_section_m2(facts: RunFacts) -> float | None:
    """Return the section of all legs and parallel wires that the load cell reads together; None if it is not stated."""
    diameter = facts.positive_or_none("wire_diameter_m")
    if diameter is None:
        return None
    whole, leg = facts.positive_or_none("wire_length_m"), facts.positive_or_none("leg_length_m")
    legs = facts.legs if whole is None or leg is None else round(whole / leg)
    own, together = facts.positive_or_none("maximum_force_n"), facts.positive_or_none("force_limit_n")
    wires = 1.0 if own is None or together is None else max(together / own, 1.0)
    return section_m2(diameter, legs) * wires


def temperature_k(recording: Recording) -> float | None:
    """Return the highest temperature of a run: of the column, or of the power by the protection's heat balance.

    None if the recording has neither. The balance is that of a wire in still air: C dT/dt = P - loss (T - ambient).
    """
    if "wire_temperature_k" in recording and len(recording):
        return float(np.nanmax(recording["wire_temperature_k"]))
    facts = recording.facts
    names = ("limit_heat_capacity_j_per_k", "limit_heat_loss_w_per_k", "limit_ambient_temperature_k")
    capacity, loss, ambient = (facts.number_or_none(name) for name in names)
    shunt, period = facts.number_or_none("shunt_resistance_ohm"), facts.number_or_none("sample_period_s")
    if capacity is None or loss is None or ambient is None or not shunt or period is None or not len(recording):
        return None
    if "wire_voltage_v" not in recording or "shunt_voltage_v" not in recording:
        return None
    power = np.nan_to_num(recording["wire_voltage_v"] * recording["shunt_voltage_v"] / shunt)
    rate = period * loss / capacity
    above = lfilter([period / capacity / (1.0 + rate)], [1.0, -1.0 / (1.0 + rate)], power)
    return ambient + float(np.max(above))
