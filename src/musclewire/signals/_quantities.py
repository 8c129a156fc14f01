"""The quantities that a wire moves by: strain, displacement, force, as a recording's instruments measured them."""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, nearest_hint
from musclewire.signals._recording import Recording

QUANTITIES = ("strain", "displacement", "force")
# NiTi takes back 8 % at most, and 3.5 in place of 0.035 is percent: no wire comes back from more than this.
MAX_STRAIN = 0.12
# Endings of the columns of each quantity: target_strain, estimated_displacement_m, target_force_n.
COLUMN_SUFFIX = {"strain": "strain", "displacement": "displacement_m", "force": "force_n"}


def reference_quantity(recording: Recording, quantity: str = "strain") -> FloatArray | None:
    """Return the measured strain, displacement [m] or contraction force [N], (n_times,); None without its instrument.

    Displacement is that of a finger's endpoint if it was measured, else that of the wire's connector. Contraction force
    is F = F_T - F_p (Lan and Fan 2010, Eq. 8), with F_p the recording's pretension or else the smallest force in it.
    """
    if quantity not in QUANTITIES:
        raise CallerError(f"there is no quantity '{quantity}'{nearest_hint(quantity, QUANTITIES)}")
    if quantity == "force":
        if "force_n" not in recording:
            return None
        pretension_n = recording.facts.number_or_none("pretension_n")
        return np.asarray(recording["force_n"] - (recording["force_n"].min() if pretension_n is None else pretension_n))
    if quantity == "displacement":
        return recording.columns.get("endpoint_displacement_m", recording.columns.get("displacement_m"))
    if "reference_strain" in recording:
        return recording["reference_strain"]
    length = recording.facts.leg_length_or_none_m
    if "displacement_m" in recording and length is not None:
        return np.asarray(recording["displacement_m"] / length)
    return None
