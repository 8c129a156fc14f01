"""The simulated rigs of the contract suite: wires and loads."""

from __future__ import annotations

from collections.abc import Callable

from tests.contract.rig_subject import PAPERS_WIRE_OHM, RigSubject, without_a_test

from musclewire.rigs import Rig, RigConfiguration, open_rig

# By the maker's ohm per metre, within his 15 %: 126 and, of the thicker wire, 75 over 14 cm; 126 over 7 cm.
SHORT_OHM = (7.5, 10.2)


def pulling(*parts: dict[str, str]) -> Callable[[], Rig]:
    """Return a factory of the finger's bench with other parts at the connector."""
    return lambda: open_rig(RigConfiguration(wire="finger-100um", bench="finger", load=list(parts)))


def simulated(name: str, make: Callable[[], Rig], cold_ohm: tuple[float, float], **known: float | bool) -> RigSubject:
    """Return a rig of the suite."""
    return RigSubject(name, without_a_test(make), cold_ohm, **known)  # type: ignore[arg-type]


# A mount of 1e6 N/m lets a wire pull, and a weight stays what it is.
SUBJECTS = (
    simulated("simulated", lambda: open_rig("simulated"), PAPERS_WIRE_OHM),
    simulated("simulated, 125 um", lambda: open_rig("simulated", wire="paper-125um"), (8.9, 12.1)),
    simulated("finger", lambda: open_rig("finger"), SHORT_OHM),
    simulated(
        "weight", pulling({"part": "weight", "force": "70 gf"}), SHORT_OHM, least_force_n=-0.01, fixed_pretension=True
    ),
    simulated("blocked", pulling({"part": "blocked"}), SHORT_OHM, least_strain=0.0, least_force_n=3.0),
)
