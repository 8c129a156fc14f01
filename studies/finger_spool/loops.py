"""Slow loops of a spool on the finger's rig: noise-free in one call, or read by the rig's instruments."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from musclewire.experiment.open_loop import slow_sine
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.rigs.configuration import FOLDER, read_rig_file
from musclewire.rigs.mechanism import Mechanism, mechanism_of
from musclewire.rigs.simulated import Instruments
from musclewire.sensing.gaps import hysteresis_gap, signed_hysteresis_gap
from musclewire.sensing.segments import find_segments
from musclewire.simulate.paths import DrivenPath, drive_path
from musclewire.simulate.stepping import fixed_steps
from musclewire.wire.building import constants_of

FloatArray = NDArray[np.float64]

PERIOD_S, CYCLES = 90.0, 2
RIG, COMMON_WIRE, OWN_WIRE = "finger", "paper-100um", "finger-100um"


@dataclass(frozen=True)
class Trial:
    """A spool and how it is driven: what differs from the paper's 100 um wire on the finger's rig, by name."""

    amplitude_v: float
    wire: dict[str, float] = field(default_factory=dict)
    alloy: dict[str, float] = field(default_factory=dict)
    bench: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class LoopRow:
    """The last cycle at one pretension; gaps of the endpoint's displacement (Eq. 9), all percentages of maxima."""

    pretension_n: float
    gap_pct: float
    signed_gap_pct: float
    stroke_pct: float
    endpoint_m: float
    min_martensite: float


def own_trial() -> Trial:
    """Return the finger's wire as its file has it."""
    values = load_wire(OWN_WIRE).values()
    return Trial(values["drive_amplitude_v"], wire=values)


@cache
def mechanism() -> Mechanism:
    """Return pretensioner and finger of the rig; the pretensioner carries the pretension, so one serves all."""
    numbers = load_bench(RIG).values()
    parts = read_rig_file(FOLDER / f"{RIG}.toml").load
    leg_m = numbers["wire_length_m"] / numbers["legs"]
    return mechanism_of(parts, pretension_n=numbers["pretension_n"], leg_length_m=leg_m)


def leg_length_m() -> float:
    """Return the length of one leg of the finger's wire."""
    numbers = load_bench(RIG).values()
    return numbers["wire_length_m"] / numbers["legs"]


def slow_path(trial: Trial, pretension_n: float, *, time_step_s: float) -> DrivenPath:
    """Return what the slow sine does to a spool, noise-free, sample by sample of the rig."""
    own = {**load_bench(RIG).values(), **trial.bench, "pretension_n": pretension_n}
    material = {**load_alloy("flexinol").values(), **trial.alloy}
    constants = constants_of(material, {**load_wire(COMMON_WIRE).values(), **trial.wire}, own, load=mechanism().load)
    period = own["sample_period_s"]
    drive_at = slow_sine(trial.amplitude_v, own["sense_voltage_v"], PERIOD_S)
    drive = np.array([drive_at(period * index) for index in range(round(CYCLES * PERIOD_S / period))])
    path, _ = drive_path(constants, drive, sample_s=period, stepping=fixed_steps(time_step_s))
    return path


def row_of(path: DrivenPath, pretension_n: float) -> LoopRow:
    """Return gaps and strokes of a noise-free path's last cycle."""
    endpoint = endpoint_of(path)
    ohm = path.wire_voltage_v / path.shunt_voltage_v * load_bench(RIG).shunt_resistance_ohm.value
    gap, signed = gaps_of(ohm, path.displacement_m, endpoint)
    last = slice(ohm.size // CYCLES * (CYCLES - 1), None)
    return LoopRow(
        pretension_n,
        gap,
        signed,
        100.0 * float(path.displacement_m[last].max()) / leg_length_m(),
        float(endpoint[last].max()),
        float(path.martensite_fraction[last].min()),
    )


def endpoint_of(path: DrivenPath) -> FloatArray:
    """Return where the finger's endpoint is [m], (n_samples,)."""
    tendon = mechanism().tendon
    if tendon is None:
        raise ValueError(f"rig {RIG} has no finger at its connector")
    return tendon.endpoint_m(path.displacement_m, 0.0)


def gaps_of(ohm: FloatArray, displacement_m: FloatArray, endpoint_m: FloatArray) -> tuple[float, float]:
    """Return the displacement gap of the last cycle and the same with its sign, heating less cooling, in percent."""
    found = find_segments(ohm, displacement_m / leg_length_m())
    up, down = slice(found.heating_b, found.heating_c + 1), slice(found.cooling_c, found.cooling_b + 1)
    heating, cooling = (ohm[up], endpoint_m[up]), (ohm[down], endpoint_m[down])
    return 100.0 * hysteresis_gap(heating, cooling), 100.0 * signed_hysteresis_gap(heating, cooling)


def read_gap_pct(path: DrivenPath, seed: int) -> float:
    """Return the displacement gap of a path as the rig's instruments read it: what an experimenter gets."""
    numbers = load_bench(RIG).values()
    instruments = Instruments(numbers, seed, at_endpoint=True)
    endpoint = endpoint_of(path)
    rows = np.empty((endpoint.size, 4))
    for index in range(endpoint.size):
        rows[index, :3] = instruments.sample(
            path.wire_voltage_v[index], path.shunt_voltage_v[index], path.displacement_m[index], 0.0
        )[:3]
        rows[index, 3], _ = instruments.endpoint(endpoint[index], 0.0)
    ohm = rows[:, 0] / rows[:, 1] * numbers["shunt_resistance_ohm"]
    return gaps_of(ohm, rows[:, 2], rows[:, 3])[0]
