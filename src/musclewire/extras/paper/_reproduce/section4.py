"""Section IV: finger and pretensioner as they are and were designed, and forces at the connector (Figs. 13 to 15)."""

from __future__ import annotations

from typing import Any

import numpy as np

from musclewire.extras.paper._reproduce.designed_parts import (
    designed_pretensioner,
    paper_pretensioner,
    schemes_of_fig13,
)
from musclewire.extras.paper._reproduce.finger_runs import pretension_n
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.rigs import simulated_configuration

# Eq. 8 is evaluated between the ends of the connector's motion: at the ends friction has yet to reverse.
EQUATION_8_SPAN = (0.05, 0.95)
# Thickness at which a stiffness is compared with the designed one's, over the designed one.
THICKER = 1.1
SIDES = ("across", "along", "out of plane")


def shipped_finger() -> Any:
    """Return the finger that the rig "finger" names."""
    configuration, _ = simulated_configuration("finger")
    return next(finger for part in configuration.load if (finger := part.finger_file()) is not None)


def range_ratio(_runs: RunCache) -> float:
    """Return range over length of the distributed tendon over that of one chord."""
    return schemes_of_fig13().ratio


def length_mm(_runs: RunCache, *, name: str) -> float:
    """Return a length of the shipped finger [mm]."""
    return float(1e3 * shipped_finger().geometry[f"{name}_m"].value)


def columns(_runs: RunCache) -> float:
    """Return the number of columns of the shipped finger."""
    return float(shipped_finger().geometry["columns"].value)


def finger_stiffness_n_per_m(_runs: RunCache) -> float:
    """Return the stiffness of the shipped finger where the tendon begins to pull."""
    return float(shipped_finger().curve.stiffness_n_per_m)


def pretensioner_stiffness_n_per_m(_runs: RunCache) -> float:
    """Return the stiffness of the designed pretensioner."""
    return designed_pretensioner().stiffness_n_per_m


def softness(runs: RunCache) -> float:
    """Return the stiffness of the pretensioner over that of the finger."""
    return pretensioner_stiffness_n_per_m(runs) / finger_stiffness_n_per_m(runs)


def force_to_finger(runs: RunCache) -> float:
    """Return the finger's part of the contraction force at the largest contraction, by the load cell."""
    recording = runs.finger.loop(pretension_n()).recording
    far = int(np.argmax(recording["displacement_m"]))
    contraction_n = recording["force_n"][far] - pretension_n()
    return float(1.0 - pretensioner_of_rig_n_per_m() * recording["displacement_m"][far] / contraction_n)


def pretensioner_of_rig_n_per_m() -> float:
    """Return the stiffness of the load without the finger's own curve: the pretensioner."""
    configuration, _ = simulated_configuration("finger")
    return sum(part.stiffness_n_per_m for part in configuration.load)


def thickness_exponent(_runs: RunCache) -> float:
    """Return the power of its in-plane thickness with which the designed pretensioner's stiffness grows."""
    made = paper_pretensioner()
    thicker = made.stiffness_at(THICKER * made.geometry.thickness_m)
    return float(np.log(thicker / made.stiffness_n_per_m) / np.log(THICKER))


def inward_gain_deg(_runs: RunCache) -> float:
    """Return the angle of the finger's end less that of the same finger with straight segments [degrees]."""
    curved, straight = (schemes_of_fig13(straight=without).schemes[0].angles_rad[-1] for without in (False, True))
    return float(np.degrees(curved - straight))


def designed_size_mm(_runs: RunCache, *, side: str) -> float:
    """Return a size of the designed pretensioner [mm]."""
    return 1e3 * designed_pretensioner().size_m[SIDES.index(side)]


def wire_length_cm(runs: RunCache) -> float:
    """Return the length of the finger's wire as its recording states it [cm]."""
    return 100.0 * runs.finger.loop(pretension_n()).recording.facts.wire_length_m


def tendon_zero_um(runs: RunCache) -> float:
    """Return how far the zero of the tendon is found from the true one [um]."""
    return 1e6 * abs(runs.finger.tendon_zero.slack_m)


def reach_mm(runs: RunCache) -> float:
    """Return the largest displacement of the endpoint over the slow sine [mm]."""
    return 1e3 * float(runs.finger.loop(pretension_n()).recording["endpoint_displacement_m"].max())


def eq8_error_n(runs: RunCache) -> float:
    """Return the rms difference of the load cell from Eq. 8 with the finger's own curve [N].

    It is over 5 to 95 % of the connector's travel, of the mean of heating and cooling, in which friction cancels.

    References
    ----------
    Lan and Fan 2010, Eq. 8.
    """
    loop = runs.finger.loop(pretension_n())
    curve, stiffness = shipped_finger().curve, pretensioner_of_rig_n_per_m()
    x = np.linspace(*EQUATION_8_SPAN, 200) * loop.recording["displacement_m"].max()
    measured = np.zeros_like(x)
    for half in loop.halves():
        displacement, force = loop.recording["displacement_m"][half], loop.recording["force_n"][half]
        order = np.argsort(displacement)
        measured += 0.5 * np.interp(x, displacement[order], force[order])
    wanted = pretension_n() + stiffness * x + np.interp(x, curve.tendon_travel_m, curve.tendon_force_n)
    return float(np.sqrt(np.mean((measured - wanted) ** 2)))


def deflection_mm(runs: RunCache, *, kept: bool) -> float:
    """Return the endpoint's displacement before heating [mm]."""
    return 1e3 * abs(runs.finger.initial_deflection_m[kept])
