"""Estimators and the closed loop on a plant of anybody's, named by its rig file, under changes of air, load and wire.

The plant is characterized as a user would. Then it follows random steps and minor loops by its displacement sensor, so
that every estimator sees the same run; 20 s after its begin one thing changes within a second. Printed for each
condition and estimator: root mean square error in percent of the stroke, from 10 s after the change on and within 10
and 90 % of the stroke, and how many samples are valid; for the loop with default estimator and gains the mean error of
the paper's staircase after the approach. The reference is the plant's true strain if it has one, otherwise the sensor.

    python studies/own_plant.py [RIG ...]    rig files; by default the wire of another family in examples/plants

A device whose attribute ``conditions`` takes a function of time to ``Conditions`` of the segmented wire is put through
all conditions, any other only through "none". A dash is where the rig's highest drive no longer warms the wire into the
range that counts. Nothing is judged: the bars are those of musclewire robustness.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

import musclewire as mw
from musclewire.arrays import FloatArray
from musclewire.errors import MusclewireError
from musclewire.extras.studies import Conditions
from musclewire.rigs import GuardedRig, HasTrueState, ability
from musclewire.sensing import ESTIMATORS, EstimatorSetup, SensingModel, estimates
from musclewire.signals import RawSample, wire_sample

LIANG_ROGERS = Path(__file__).resolve().parents[1] / "examples" / "plants" / "liang_rogers.toml"
NAMES = ("polynomial", "filter")
PERIOD_S, CHANGE_S, RAMP_S, JUDGED_S = 100.0, 20.0, 1.0, 31.0
LOW, HIGH = 0.1, 0.9
# PI controller of the heating power on the measured strain, both per error in strokes.
GAIN, INTEGRAL_S = 6.0, 1.2
SEED = 11


class Change(NamedTuple):
    """What has changed once a condition is there, beyond or as a multiple of what was before."""

    warmer_k: float = 0.0
    convection: float = 1.0
    load: float = 0.0
    stiffness: float = 1.0
    resistance: float = 1.0
    shift_k: float = 0.0

    def at(self, level: float, ambient_k: float, pretension_n: float) -> Conditions:
        """Return the conditions at a level, 0 to 1; the load is a multiple of the pretension."""
        return Conditions(
            ambient_k=ambient_k + level * self.warmer_k,
            convection_factor=1.0 + level * (self.convection - 1.0),
            load_force_n=level * self.load * pretension_n,
            stiffness_factor=1.0 + level * (self.stiffness - 1.0),
            resistance_factor=1.0 + level * (self.resistance - 1.0),
            transformation_shift_k=level * self.shift_k,
        )


CONDITIONS = {
    "none": Change(),
    "ambient +15 K": Change(warmer_k=15.0),
    "ambient -15 K": Change(warmer_k=-15.0),
    "h x0.5": Change(convection=0.5),
    "h x3": Change(convection=3.0),
    "load +50 %": Change(load=0.5),
    "load -50 %": Change(load=-0.5),
    "k x0.5": Change(stiffness=0.5),
    "k x2": Change(stiffness=2.0),
    "R +1 %": Change(resistance=1.01),
    "T +5 K": Change(shift_k=5.0),
}


def disturb(rig: GuardedRig, name: str) -> None:
    """Give a plant the conditions of a name."""
    limits, pretension_n = rig.protection_limits, float(rig.metadata().get("pretension_n") or 0.0)

    def conditions(time_s: float) -> Conditions:
        level = min(max((time_s - CHANGE_S) / RAMP_S, 0.0), 1.0)
        return CONDITIONS[name].at(level, limits.ambient_temperature_k, pretension_n)

    if hasattr(rig.device, "conditions"):
        rig.device.conditions = conditions


def targets(random: np.random.Generator, samples: int, period_s: float) -> FloatArray:
    """Return random steps for half of the time, then sines around centres that move, as fractions of the stroke."""
    time_s = period_s * np.arange(samples)
    held = np.repeat(random.uniform(0.15, 0.85, samples), round(3.0 / period_s))[:samples]
    centre = np.repeat(random.uniform(0.35, 0.65, samples), round(10.0 / period_s))[:samples]
    size = np.repeat(random.uniform(0.05, 0.2, samples), round(10.0 / period_s))[:samples]
    return np.where(time_s < 0.5 * PERIOD_S, held, centre + size * np.sin(2.0 * np.pi * time_s / 7.0))


def followed(rig: GuardedRig, stroke: float) -> tuple[list[RawSample], FloatArray]:
    """Drive a plant along targets by its displacement sensor; return the samples and the reference strain of each."""
    truth, period_s = ability(rig, HasTrueState), rig.sample_period_s
    low, full, high = rig.sense_voltage_v**2, rig.drive_amplitude_v**2, rig.maximum_voltage_v**2
    integral, drive_v, samples, strains = 0.0, rig.sense_voltage_v, [], []
    for target in targets(np.random.default_rng(SEED), round(PERIOD_S / period_s), period_s).tolist():
        sample = rig.exchange(drive_v)
        strain = (sample.displacement_m or 0.0) / rig.leg_length_m
        state = None if truth is None else truth.wire_state
        strains.append(getattr(state, "mean_strain", strain))
        samples.append(sample)
        error = target - strain / stroke
        wanted = full * GAIN * (error + integral)
        if low < wanted < high or (wanted > low) != (error > 0.0):
            integral += error * period_s / INTEGRAL_S
        drive_v = float(np.sqrt(min(max(wanted, low), high)))
    return samples, np.array(strains)


def error_of(
    name: str, model: SensingModel, rig: GuardedRig, run: tuple[list[RawSample], FloatArray]
) -> tuple[float, float]:
    """Return the error of an estimator [% of stroke rms] and how many samples are valid [%]."""
    samples, strain = run
    made = ESTIMATORS.find(name)(EstimatorSetup(model, rig.shunt_resistance_ohm, rig.sample_period_s))
    found = [estimate for estimate, _ in estimates(made, [wire_sample(one) for one in samples])]
    stroke = model.quantity_max - model.quantity_min
    time_s = np.array([one.time_s for one in samples])
    chosen = (time_s > JUDGED_S) & (strain > LOW * stroke) & (strain < HIGH * stroke)
    value, valid = (np.array([getattr(one, name) for one in found]) for name in ("value", "valid"))
    if not chosen.any():
        return math.nan, math.nan
    error = 100.0 * (value - strain)[chosen] / stroke
    return float(np.sqrt(np.mean(error**2))), 100.0 * float(np.mean(valid[chosen]))


def loop_error_pct(rig_file: Path, model: SensingModel, condition: str) -> str:
    """Return the mean error of the staircase after the approach [%], or why the loop ended."""
    with mw.open_rig(rig_file, seed=SEED) as rig:
        disturb(rig, condition)
        try:
            return f"{mw.control(rig, model).metrics.mae_mean_approached_pct:6.2f}"
        except MusclewireError as error:
            return type(error).__name__


def in_text(number: float, digits: int) -> str:
    """Return a number with so many digits, or a dash for none."""
    return "-" if math.isnan(number) else f"{number:.{digits}f}"


def main() -> None:
    """Print the table of each rig."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rigs", nargs="*", type=Path, default=[LIANG_ROGERS])
    for rig_file in parser.parse_args().rigs:
        with mw.open_rig(rig_file) as rig:
            model = mw.fit(mw.characterize(rig, minor_loop=False))
            names = list(CONDITIONS) if hasattr(rig.device, "conditions") else ["none"]
        stroke = model.quantity_max - model.quantity_min
        print(f"{rig_file.name}: stroke {100.0 * stroke:.2f} %, gap {100.0 * model.hysteresis_gap:.2f} %")
        print("condition       " + "".join(f"{name:>12} rms %  valid %" for name in NAMES) + "   loop, mean MAE %")
        for condition in names:
            with mw.open_rig(rig_file, seed=SEED) as rig:
                disturb(rig, condition)
                run = followed(rig, stroke)
                rows = [error_of(name, model, rig, run) for name in NAMES]
            numbers = "".join(f"{in_text(error, 2):>18}  {in_text(valid, 1):>7}" for error, valid in rows)
            print(f"{condition:<16}{numbers}   {loop_error_pct(rig_file, model, condition):>16}")


if __name__ == "__main__":
    main()
