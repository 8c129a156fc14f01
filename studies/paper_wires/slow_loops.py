"""Slow sines of a candidate's spools on their benches, noise-free."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from musclewire.parameters import Bench, Wire, load_bench
from musclewire.rigs import SimulatedLoad, mechanism_of, read_rig_file, shipped_rig_files
from musclewire.wire import DrivenPath, WireConstants, constants_from, drive_path, fixed_steps
from paper_wires.loops import Loop, analysed
from paper_wires.unknowns import PaperWires, changed

# Ten samples a second, a step each: halving both moves no target by more than 0.02 of its tolerance.
SAMPLE_S, PERIOD_S = 0.1, 90.0
RAISED_COSINE = 0.5 * (1.0 - np.cos(2.0 * math.pi * np.arange(0.0, PERIOD_S, SAMPLE_S) / PERIOD_S))


def slow_loop(
    wires: PaperWires,
    spool: str,
    pretension_n: float,
    *,
    amplitude_v: float | None = None,
    stiffness: float = 1.0,
) -> Loop:
    """Return one slow sine of a spool on the bench of section II."""
    bench = changed(
        wires.bench,
        pretension_n=pretension_n,
        spring_stiffness_n_per_m=stiffness * wires.bench.spring_stiffness_n_per_m.value,
    )
    constants = constants_from(wires.alloy, wires.wires[spool], bench)
    path = driven(constants, bench, wires.amplitude_v(spool) if amplitude_v is None else amplitude_v)
    return analysed(path, path.displacement_m / constants.leg_length_m, pretension_n, constants)


def finger_loop(wires: PaperWires, pretension_n: float) -> Loop:
    """Return one slow sine on the finger: the loop of its endpoint's displacement [m] in place of strain."""
    bench = changed(wires.finger_bench, pretension_n=pretension_n)
    spool: Wire = wires.wires["finger"]
    constants = constants_from(wires.alloy, spool, bench, load=finger().load)
    path = driven(constants, bench, wires.amplitude_v("finger"))
    tendon = finger().tendon
    if tendon is None:
        raise ValueError("rig finger has no finger at its connector")
    return analysed(path, tendon.endpoint_m(path.displacement_m, 0.0), pretension_n, constants)


def driven(constants: WireConstants, bench: Bench, amplitude_v: float) -> DrivenPath:
    """Return the response to one period from the sense voltage up."""
    sense_v = bench.sense_voltage_v.value
    drive = sense_v + (amplitude_v - sense_v) * RAISED_COSINE
    path, _ = drive_path(constants, drive, sample_s=SAMPLE_S, stepping=fixed_steps(SAMPLE_S))
    return path


@cache
def finger() -> SimulatedLoad:
    """Return pretensioner and finger of the rig; the pretensioner carries the pretension, so one serves all."""
    bench = load_bench("finger")
    parts = read_rig_file(shipped_rig_files()["finger"]).load
    leg_m = bench.wire_length_m.value / bench.legs.value
    return mechanism_of(parts, pretension_n=bench.pretension_n.value, leg_length_m=leg_m)
