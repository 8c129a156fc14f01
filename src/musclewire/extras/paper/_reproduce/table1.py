"""Table 1 and the numbers of section 2.1: how ours are found, in wire files and on the simulated wires."""

from __future__ import annotations

from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.parameters import load_wire

WIRES = ("paper-100um", "paper-125um", "paper-200um")


def wire_name(diameter_um: int) -> str:
    """Return the name of the paper's wire of a diameter."""
    return f"paper-{diameter_um}um"


def diameter_label(wire: str) -> str:
    """Return the diameter in a wire's name: "100um"."""
    return wire.removeprefix("paper-")


def wire_number(_runs: RunCache, *, name: str, diameter_um: int, factor: float = 1.0) -> float:
    """Return a number of a wire file."""
    return factor * load_wire(wire_name(diameter_um)).values()[name]


def cold_resistance(runs: RunCache, *, diameter_um: int) -> float:
    """Return ohm per metre of the cold simulated wire."""
    return runs.cold_resistance_per_metre(wire_name(diameter_um))


def stress_spread_pct(_runs: RunCache, *, force: str) -> float:
    """Return largest less smallest stress over their mean, a force over one section [%]."""
    wires = [load_wire(wire).values() for wire in WIRES]
    stress = [wire[f"{force}_force_n"] / wire["diameter_m"] ** 2 for wire in wires]
    return 100.0 * (max(stress) - min(stress)) * len(stress) / sum(stress)


def force_ratio(runs: RunCache, *, diameter_um: int, force_n: float) -> float:
    """Return the mean force of the first second over the wire's maximal force."""
    wire = wire_name(diameter_um)
    recording = runs.loop(wire, force_n).recording
    first = recording["time_s"] <= recording["time_s"][0] + 1.0
    return float(recording["force_n"][first].mean()) / load_wire(wire).maximum_force_n.value


def noted(runs: RunCache, *, key: str, factor: float = 1.0) -> float:
    """Return a number that the main loop's recording states."""
    return factor * runs.main_loop().recording.facts.number(key, "setting of the paper that Table 1 compares")


def main_frequency_hz(runs: RunCache) -> float:
    """Return the frequency of the slow sine."""
    return 1.0 / runs.main_loop().recording.facts.period_s
