"""Do two calibrations that share a recording agree within what they state?

Wires of the population of `musclewire robustness`, whose alloy, spool and bench differ from ours, are each calibrated
twice: from the slow loop with one minute of random steps, and from the same slow loop with another minute. Bar: of all
parameters at most one in a hundred is more than 3 stated deviations of the difference apart. Exit 1 where it fails.

    pip install ./studies/robustness
    python studies/calibrations_that_share.py [--quick]     12 wires, 107 to 118, or 2 without a verdict
"""

from __future__ import annotations

import sys

import numpy as np
from musclewire_robustness.characterizing import random_drive, slow_loop
from musclewire_robustness.plant import open_plant
from musclewire_robustness.population import PopulationWire, drawn_wire

from musclewire.experiment import WaveformPolicy, run_on_rig
from musclewire.extras.calibration import Calibration, SearchSettings, calibrate
from musclewire.signals import Recording

WIRES, QUICK_WIRES = range(107, 119), range(107, 109)
STEPS_S, MAX_DEVIATIONS, MAX_APART = 60.0, 3.0, 0.01


def random_steps(wire: PopulationWire, amplitude_v: float, run: int) -> Recording:
    """Return a minute of random steps of a wire; each run has steps and noise of its own."""
    with open_plant(wire, run=run).rig as rig:
        drive = random_drive(rig.sense_voltage_v, amplitude_v, STEPS_S, 1000 * run + wire.seed)
        return run_on_rig(rig, WaveformPolicy(drive, STEPS_S), STEPS_S, metadata={"experiment": "random steps"})


def calibrations(seed: int) -> list[Calibration]:
    """Return two calibrations of a wire that share its slow loop."""
    wire = drawn_wire(seed)
    loop = slow_loop(wire)
    amplitude_v = loop.facts.number_or_none("amplitude_v")
    assert amplitude_v is not None
    return [
        calibrate(
            {"slow loop": loop, "random steps": random_steps(wire, amplitude_v, run)},
            wire=wire.base,
            settings=SearchSettings(seed=seed + run),
        )
        for run in (2, 3)
    ]


def main() -> int:
    quick = "--quick" in sys.argv
    apart = parameters = 0
    print("wire  sums of squares  identifiable  over 3 deviations  farthest", flush=True)
    for seed in QUICK_WIRES if quick else WIRES:
        one, other = calibrations(seed)
        deviations = [
            abs(first.value - second.value) / np.hypot(first.std, second.std)
            for first, second in zip(one.estimates, other.estimates, strict=True)
        ]
        far, farthest = sum(each > MAX_DEVIATIONS for each in deviations), int(np.argmax(deviations))
        identifiable = [sum(item.identifiable for item in found.estimates) for found in (one, other)]
        costs = "{:.0f}, {:.0f}".format(*(found.search_result.cost for found in (one, other)))
        print(
            f"{seed:4d}  {costs:>15}  {'{}, {}'.format(*identifiable):>12}  {far:>6} of {len(deviations):>2}         "
            f"{one.estimates[farthest].name} {deviations[farthest]:.1f}",
            flush=True,
        )
        apart, parameters = apart + far, parameters + len(deviations)
    holds = apart <= MAX_APART * parameters
    print(f"{apart} of {parameters} parameters more than {MAX_DEVIATIONS:g} deviations apart (bar: 1 in 100)", end="")
    print("" if quick else f": {'holds' if holds else 'FAILS'}")
    return 0 if holds or quick else 1


if __name__ == "__main__":
    sys.exit(main())
