"""What a home move makes of a model after each disturbance: the error of the estimate before it and after it.

A wire is characterised on the paper's bench. Then something changes (the air, the load, the wire itself, a lead), the
home move is made, and the wire is driven by steps at random. The estimate's error is the root mean square over the
samples between B and C, in percent of the stroke, by the model as it was and by the model after the home move, on the
same samples. The change is unknown to the program: the rig states load, air and heat loss of the characterisation.
Displacement counts from the wire as characterised, so that a changed load moves its zero (``kept``), or from the wire
as it is now (``anew``).

    python benchmarks/home_move.py [--seeds N] [--json]

Each row has the median and the largest over the seeds; a refused home move leaves the model as it was and is counted.
Ends with exit code 1 if a home move makes the median of any row worse by more than 0.1 % of stroke, or if a row after
ageing or longer leads is above 1.5 % (1.0 % with a thermometer).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from statistics import median
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import musclewire as mw
from musclewire.controllers import ProtectionLimits
from musclewire.errors import MusclewireError
from musclewire.experiment import WaveformPolicy, run_on_rig
from musclewire.identify import resistance_reading
from musclewire.rigs import GuardedRig, SimulatedDevice
from musclewire.sensing import SensingModel
from musclewire.signals import RawSample, Recording

PRETENSION_N, STIFFNESS_N_PER_M, AIR_K, CONVECTION = 1.9, 588.6, 295.15, 0.817678
SHIFT_K = 4.99717
LEAD = "lead_ohm"
CASES: dict[str, dict[str, float]] = {
    "none": {},
    **{f"air {change:+g} K": {"ambient_temperature_k": AIR_K + change} for change in (10, -10, 15, -15)},
    "stiffness x2": {"spring_stiffness_n_per_m": 2.0 * STIFFNESS_N_PER_M},
    "stiffness x0.5": {"spring_stiffness_n_per_m": 0.5 * STIFFNESS_N_PER_M},
    "load +50 %": {"pretension_n": 1.5 * PRETENSION_N},
    "load -50 %": {"pretension_n": 0.5 * PRETENSION_N},
    "R +1 %": {"resistivity_factor": 1.01},
    "R -1 %": {"resistivity_factor": 0.99},
    "T +5 K": {"temperature_shift_k": SHIFT_K + 5.0},
    "T -5 K": {"temperature_shift_k": SHIFT_K - 5.0},
    "h x0.5": {"convection_factor": 0.5 * CONVECTION},
    "h x3": {"convection_factor": 3.0 * CONVECTION},
    "lead 0.5 ohm": {LEAD: 0.5},
}
# The rows that a home move is for, and their bars in percent of stroke without and with an air thermometer.
BARRED = ("R +1 %", "R -1 %", "T +5 K", "T -5 K", "lead 0.5 ohm")
BARS = (1.5, 1.0)
WORSE_PCT = 0.1
# Each wire differs from the alloy's by this much, as spools of one maker do.
SPREAD = {"resistivity_factor": 0.03, "convection_factor": 0.10}
SPREAD_SHIFT_K = 5.0
USABLE = (0.15, 0.90)
RUN_S, STEP_S = 160.0, 8.0


class Outcome(NamedTuple):
    """Errors of one home move [% of stroke], and why it was refused, "" if it was not."""

    before_pct: float
    after_pct: float
    refused: str
    corrected: bool


class LongerLeads:
    """A simulated device with longer leads inside the measured voltage, which states what was characterised."""

    def __init__(self, device: SimulatedDevice, lead_ohm: float, limits: ProtectionLimits | None) -> None:
        """Keep the device; ``limits`` are those of the rig as characterised, the device's own if None."""
        self._device, self._lead_ohm = device, lead_ohm
        self.facts = device.facts if limits is None else replace(device.facts, limits=limits)

    def __getattr__(self, name: str) -> Any:
        """Return what is the device's own."""
        return getattr(self._device, name)

    def metadata(self) -> dict[str, Any]:
        """Return the device's, with the load that the rig believes to have."""
        known = {"pretension_n": PRETENSION_N, "spring_stiffness_n_per_m": STIFFNESS_N_PER_M}
        return {**self._device.metadata(), **known}

    def exchange(self, command: Any) -> Any:
        """Return the device's sample, with the voltage across the leads added to the wire's."""
        answer = self._device.exchange(command)
        if not isinstance(answer, RawSample) or not self._lead_ohm:
            return answer
        current_a = answer.shunt_voltage_v / self._device.facts.limits.shunt_resistance_ohm
        return answer._replace(wire_voltage_v=answer.wire_voltage_v + self._lead_ohm * current_a)


def wire_of(seed: int) -> dict[str, float]:
    """Return a wire's own numbers, drawn by its seed."""
    draw = np.random.default_rng([seed, 14])
    return {
        "resistivity_factor": 1.0 + SPREAD["resistivity_factor"] * float(draw.standard_normal()),
        "convection_factor": CONVECTION * (1.0 + SPREAD["convection_factor"] * float(draw.standard_normal())),
        "temperature_shift_k": SHIFT_K + SPREAD_SHIFT_K * float(draw.standard_normal()),
    }


def changed(wire: Mapping[str, float], case: Mapping[str, float]) -> dict[str, float]:
    """Return a wire's numbers after a change: the case's are those of the nominal wire."""
    nominal = {"resistivity_factor": 1.0, "convection_factor": CONVECTION}
    found = dict(wire)
    for name, value in case.items():
        if name in nominal:
            found[name] = wire[name] * value / nominal[name]
        elif name == "temperature_shift_k":
            found[name] = wire[name] + value - SHIFT_K
        elif name != LEAD:
            found[name] = value
    return found


def opened(
    numbers: Mapping[str, float], seed: int, lead_ohm: float = 0.0, limits: ProtectionLimits | None = None
) -> GuardedRig:
    """Return a rig with these numbers, held by its guard."""
    rig = mw.open_rig("simulated", seed=seed, **numbers)
    assert isinstance(rig.device, SimulatedDevice)
    return GuardedRig(LongerLeads(rig.device, lead_ohm, limits))  # type: ignore[arg-type]


def cold_strain(rig: GuardedRig) -> float:
    """Return the strain of the cold wire over stress-free austenite."""
    return float(rig.device.inside().wires.constants.cold_strain)  # type: ignore[attr-defined]


def random_steps(seed: int, hot_v: float) -> WaveformPolicy:
    """Return steps of the drive at random over the range in which the wire transforms."""
    levels = np.random.default_rng([seed, 15]).uniform(0.5 * hot_v, hot_v, int(RUN_S / STEP_S) + 2)

    def drive_v(time_s: float) -> float:
        return float(levels[int(time_s // STEP_S)])

    return WaveformPolicy(drive_v, RUN_S)


def hottest_v(rig: GuardedRig, loss_ratio: float) -> float:
    """Return the highest drive voltage of the steps: what the wire's limit of temperature allows, and its voltage."""
    limits, low_ohm = rig.protection_limits, 15.0
    power_w = 0.9 * loss_ratio * limits.heat_loss_w_per_k * (limits.maximum_temperature_k - AIR_K)
    circuit_ohm = low_ohm + limits.shunt_resistance_ohm
    return float(min(limits.maximum_voltage_v, circuit_ohm * np.sqrt(power_w / low_ohm), 3.4))


def error_pct(model: SensingModel, recording: Recording, zero: float) -> float:
    """Return the root mean square error of a model over a run [% of stroke], ``zero`` being added to the strain."""
    reading = resistance_reading(recording)
    strain = recording["displacement_m"] / recording.facts.leg_length_m + zero
    stroke = model.quantity_max - model.quantity_min
    low, high = (model.quantity_min + part * stroke for part in USABLE)
    used: NDArray[np.bool_] = reading.valid & (strain > low) & (strain < high) & (recording["time_s"] > STEP_S)
    if not used.any():
        return float("nan")
    estimated = model.strain(reading.resistance_ohm[used])
    return float(100.0 * np.sqrt(np.mean((estimated - strain[used]) ** 2)) / stroke)


def outcome(seed: int, case: str, thermometer: bool, kept: bool) -> Outcome:
    """Return what one home move makes of one wire's model."""
    wire = wire_of(seed)
    with opened(wire, seed) as rig:
        model = mw.fit(mw.characterize(rig))
        before, limits = cold_strain(rig), rig.protection_limits
    numbers, lead_ohm = changed(wire, CASES[case]), CASES[case].get(LEAD, 0.0)
    air_k = numbers.get("ambient_temperature_k", AIR_K) if thermometer else None
    homed, refused, corrected = model, "", False
    with opened(numbers, seed + 1000, lead_ohm, limits) as rig:
        try:
            found = mw.home(rig, model, ambient_k=air_k)
            homed, corrected = found.model, found.home.corrected
        except MusclewireError as error:
            refused = str(error)
    with opened(numbers, seed + 2000, lead_ohm, limits) as rig:
        zero = before - cold_strain(rig) if kept else 0.0
        run = run_on_rig(rig, random_steps(seed, hottest_v(rig, 0.5 if case == "h x0.5" else 1.0)), RUN_S)
    return Outcome(error_pct(model, run, zero), error_pct(homed, run, zero), refused, corrected)


def row(case: str, seeds: Sequence[int], thermometer: bool, kept: bool) -> dict[str, Any]:
    """Return a row of the table: a disturbance over all seeds."""
    found = [outcome(seed, case, thermometer, kept) for seed in seeds]
    causes = sorted({one.refused for one in found if one.refused})
    return {
        "case": case,
        "thermometer": thermometer,
        "zero": "kept" if kept else "anew",
        "before_pct": median(one.before_pct for one in found),
        "before_worst_pct": max(one.before_pct for one in found),
        "after_pct": median(one.after_pct for one in found),
        "after_worst_pct": max(one.after_pct for one in found),
        "worst_change_pct": max(one.after_pct - one.before_pct for one in found),
        "corrected": sum(one.corrected for one in found),
        "refused": sum(bool(one.refused) for one in found),
        "causes": causes,
    }


def misses(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what does not hold, a line each."""
    found = []
    for one in rows:
        name = f"{one['case']} ({'with' if one['thermometer'] else 'without'} thermometer, zero {one['zero']})"
        if one["after_pct"] > one["before_pct"] + WORSE_PCT:
            found.append(f"{name}: {one['before_pct']:.2f} % before, {one['after_pct']:.2f} % after")
        if one["case"] in BARRED and one["after_pct"] > BARS[one["thermometer"]]:
            found.append(f"{name}: {one['after_pct']:.2f} % after, {BARS[one['thermometer']]:g} % at most")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5, help="number of wires")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    asked = parser.parse_args(arguments)
    seeds = range(1, asked.seeds + 1)
    rows = [
        row(case, seeds, thermometer, kept) for thermometer in (False, True) for kept in (True, False) for case in CASES
    ]
    missed = misses(rows)
    if asked.json:
        print(json.dumps({"rows": rows, "misses": missed}, indent=1))
        return 1 if missed else 0
    print(f"errors in % of stroke, median (largest) of {asked.seeds} wires; polynomial of Eqs. 3 to 5")
    for one in rows:
        if one["case"] == "none":
            print(f"\n{'with' if one['thermometer'] else 'without'} thermometer, zero of the instrument {one['zero']}")
        print(
            f"{one['case']:15} before {one['before_pct']:5.2f} ({one['before_worst_pct']:5.2f})  after "
            f"{one['after_pct']:5.2f} ({one['after_worst_pct']:5.2f})  corrected {one['corrected']}, refused "
            f"{one['refused']} {one['causes'][0][:110] if one['causes'] else ''}"
        )
    print("\n".join(["", *missed] if missed else ["", "nothing missed"]))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
