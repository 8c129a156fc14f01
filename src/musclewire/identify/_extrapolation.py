"""What a run reached against the limits of its alloy and its vendor: warnings, and whether more drive shows more."""

from __future__ import annotations

import numpy as np

from musclewire.errors import RecordingError
from musclewire.parameters import ReachedConditions, ValidityLimits, beyond_validity, exceeds, section_m2
from musclewire.sensing import HotEnd, noise_level
from musclewire.signals import Recording, RunFacts
from musclewire.wire import HeatBalance

# Readings of a load cell are taken for as many standard deviations of its noise less extreme than they are.
NOISES = 4.0
# Nearer than this [K] to the temperature up to which the alloy was measured there is no room for more drive.
ROOM_K = 5.0
ZERO_CELSIUS_K = 273.15


def extrapolation_warnings(recording: Recording) -> tuple[str, ...]:
    """Return a warning for each limit of its alloy that a run exceeds; none for a recording that states no limits."""
    limits = ValidityLimits.stated_in(recording.metadata)
    return beyond_validity(limits, reached_in(recording)) if limits.facts() else ()


def hot_end(recording: Recording) -> HotEnd:
    """Return what a slow loop says of its hottest point besides resistance and strain: is it C, and is more to be had.

    A recording of another program states neither; then the person who drives the wire has to know.
    """
    limits, reached = ValidityLimits.stated_in(recording.metadata), reached_in(recording)
    levelled = recording.metadata.get("shows_c") is True
    highest_k, reached_k = limits.covered_temperature_high_k, reached.temperature_k
    if exceeds(reached.largest_stress_pa, limits.working_stress_pa):
        return HotEnd(levelled, "more drive would pull harder still, and the wire is above its vendor's stress already")
    if highest_k is None or reached_k is None:
        return HotEnd(levelled)
    at = f"by its power the wire reached {reached_k - ZERO_CELSIUS_K:.0f} C"
    measured = f"the {highest_k - ZERO_CELSIUS_K:.0f} C up to which the alloy was measured"
    if reached_k > highest_k - ROOM_K:
        return HotEnd(levelled, f"more drive is no way on, {at} of {measured}")
    return HotEnd(levelled, f"a higher amplitude shows more: {at}, below {measured}")


def reached_in(recording: Recording) -> ReachedConditions:
    """Return a run's stresses, by load cell over all its sections or else by pretension, and temperature, if shown."""
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

    None if the recording has neither. The wire begins cold; its loss grows with temperature as that to still air does,
    where the recording states the wire's diameter.
    """
    if "wire_temperature_k" in recording and len(recording):
        return float(np.nanmax(recording["wire_temperature_k"]))
    facts = recording.facts
    try:
        heat = HeatBalance.stated_in(facts)._replace(diameter_m=facts.positive_or_none("wire_diameter_m"))
        power = recording["wire_voltage_v"] * recording["shunt_voltage_v"] / facts.shunt_resistance_ohm
    except RecordingError:
        return None
    power = np.nan_to_num(power)
    return float(heat.along_k(recording["time_s"], power, power, 0.0, heat.air_k).max(initial=heat.air_k))
