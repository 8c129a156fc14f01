"""The simulated rigs of the contract suite with two wires."""

from __future__ import annotations

from tests.contract.simulated_rigs import SHORT_OHM, pulling, simulated

from musclewire.rigs import open_rig

PRETENSIONER = {"part": "pretensioner", "stiffness": "386.2 N/m"}
# A cold antagonist must be stretched first, and fingers that meet pull harder. Two wires stand beside or behind each
# other.
SUBJECTS = (
    simulated(
        "antagonist",
        pulling({"part": "antagonist", "voltage": "0.3 V"}),
        SHORT_OHM,
        least_strain=0.004,
        least_force_n=2.0,
    ),
    simulated(
        "parallel wire",
        pulling(PRETENSIONER, {"part": "parallel wire"}),
        (0.5 * SHORT_OHM[0], 0.5 * SHORT_OHM[1]),
    ),
    simulated(
        "two fingers",
        lambda: open_rig("gripper"),
        (2.0 * SHORT_OHM[0], 2.0 * SHORT_OHM[1]),
        least_strain=0.012,
        least_force_n=2.0,
    ),
)
