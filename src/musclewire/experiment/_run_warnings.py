"""Everything that a finished run warns of: force, stress and temperature, friction that holds, steps too long."""

from __future__ import annotations

import numpy as np

from musclewire.identify import extrapolation_warnings
from musclewire.judge import judgement_of
from musclewire.sensing import noise_level
from musclewire.signals import Recording, asked_once

# Friction counts as holding the wire from this fraction of a leg's length on: 0.01 points of strain.
HELD_FRACTION = 1e-4
# A step's error counts from here on: twenty times the tolerance of chosen steps. From 2 K on the rig itself refuses.
STEP_ERROR_K = 0.1
# What a recording may say of itself: another load, pulses read at a wrong time, what a model lacks.
STATED = (
    "model_does_not_hold",
    "other_load",
    "pwm_problem",
    "without_gains",
    "without_filter",
    "b_not_compared",
    "cooling_not_compared",
    "zero_of_room",
    "held_back",
)


def run_warnings(recording: Recording) -> tuple[str, ...]:
    """Return the warnings of a run, the most dangerous first; none for a run without any."""
    beyond, found = asked_once(recording, extrapolation_warnings), judgement_of(recording)
    said = filter(None, map(recording.facts.text_or_none, STATED))
    own = (*friction_warnings(recording), *step_warnings(recording), *said, *found.not_compared)
    return (*force_warnings(recording), *beyond, *found.warnings, *own)


def found_in(recording: Recording) -> dict[str, str]:
    """Return what is found in a run, for its own metadata: limits of the alloy, and of a loop what is wrong with it."""
    beyond = asked_once(recording, extrapolation_warnings)
    return {**({"extrapolation": "; ".join(beyond)} if beyond else {}), **judgement_of(recording).metadata}


def instrument_warnings(recording: Recording) -> tuple[str, ...]:
    """Return the warnings of a run but for those of stress and temperature beyond its alloy's limits."""
    return (*force_warnings(recording), *friction_warnings(recording), *step_warnings(recording))


def step_warnings(recording: Recording) -> tuple[str, ...]:
    """Return a warning if the steps of a simulation were so long that they show; none otherwise."""
    error_k = recording.facts.number_or_none("step_error_k")
    step_s = recording.facts.number_or_none("time_step_s")
    if error_k is None or error_k <= STEP_ERROR_K:
        return ()
    steps = f"fixed steps of {1e3 * step_s:g} ms" if step_s else "steps chosen by tolerance"
    return (
        f"the steps of the simulation show: {steps} left an error of up to {error_k:.2g} K in temperature: set "
        "time_step_s to 0 for chosen steps, to a shorter step, or lower temperature_tolerance_k",
    )


def friction_warnings(recording: Recording) -> tuple[str, ...]:
    """Return a simulated rig's warning if friction held the connector while the wire became slack; none otherwise."""
    held_m = recording.facts.number_or_none("friction_held_m")
    leg_m = recording.facts.leg_length_or_none_m
    if held_m is None or leg_m is None or held_m <= HELD_FRACTION * leg_m:
        return ()
    return (
        f"friction holds the wire: cooling, it became up to {1e3 * held_m:.2f} mm longer than the connector let it, "
        "since the load cannot pull guide and wire back; displacement, strain and force then show the friction: more "
        "pretension, a stiffer spring, or a guide with less friction",
    )


# A reading counts as above the limit if it exceeds it by this many standard deviations of the load cell's noise.
NOISES = 4.0


def force_limit_n(recording: Recording) -> float | None:
    """Return the force allowed in a recording's run [N], None if it states neither its own limit nor the wire's."""
    limit = recording.facts.number_or_none("force_limit_n")
    return recording.facts.number_or_none("maximum_force_n") if limit is None else limit


def force_warnings(recording: Recording) -> tuple[str, ...]:
    """Return a warning if ``force_n`` exceeds ``force_limit_n`` or else ``maximum_force_n`` [N]; none otherwise."""
    limit = force_limit_n(recording)
    if "force_n" not in recording or limit is None:
        return ()
    force, time = recording["force_n"], recording["time_s"]
    above = force > limit + NOISES * noise_level(force)
    if not above.any():
        return ()
    worst = int(np.argmax(force))
    step_s = float(np.median(np.diff(time))) if time.size > 1 else 0.0
    drive = f", drive {recording['drive_voltage_v'][worst]:.2f} V" if "drive_voltage_v" in recording else ""
    whose = f" of wire {wire}" if (wire := recording.facts.text_or_none("wire")) else ""
    together = "parallel wire" in recording.facts.load
    over_s = step_s * int(above.sum())
    return (
        f"{'the wires pull' if together else 'the wire pulls'} with up to {force[worst]:.2f} N at {time[worst]:.1f} s"
        f"{drive}, {force[worst] - limit:.2f} N above the {limit:g} N allowed (maximum_force_n{whose}), and above it "
        f"for {over_s:.1f} s in total: drive less, set less pretension, or take a softer load or a thicker wire",
    )
