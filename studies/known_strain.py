"""What one known strain makes of a loop whose load, spring, resistance or room has changed since its characterization.

Each loop runs the staircase from 1.2 % in changed conditions, without `control --known-strain` and with what the ruler
reads after 11.5 s, in the second step; both are judged from 1 s later on, where the estimate is valid. Bar: where the
estimate missed it by more than its interval, the 95 % intervals then hold in at least 90 % of the samples. Exit 1 where
they do not.

    python studies/known_strain.py [--quick]     two wires, seeds 5 to 7; or the paper's wire, seed 5
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

import musclewire as mw
from musclewire import RigConfiguration
from musclewire.rigs import GuardedRig

WIRES, SEEDS, FIT_SEED = ("paper-100um", "paper-125um"), (5, 6, 7), 3
KNOWN_AT_S, SETTLED_S, MIN_HELD = 11.5, 1.0, 0.9
RESISTANCES = {"R +1 %": 1.01, "R -1 %": 0.99}
# Factors on what the rig of the characterization states.
RIGS: dict[str, dict[str, float]] = {
    "nothing": {},
    "load +50 %": {"pretension_n": 1.5},
    "load -50 %": {"pretension_n": 0.5},
    "spring x2": {"spring_stiffness_n_per_m": 2.0},
    "spring x0.5": {"spring_stiffness_n_per_m": 0.5},
    "room +15 K": {"ambient_temperature_k": 310.15 / 295.15},
    "room -15 K": {"ambient_temperature_k": 280.15 / 295.15},
}


def opened(wire: str, seed: int, settings: dict[str, float]) -> GuardedRig:
    """Return the simulated rig with a wire."""
    return mw.open_rig(RigConfiguration(wire=wire, settings=settings), seed=seed)


def run(
    model: mw.SensingModel, wire: str, seed: int, settings: dict[str, float], known: tuple[float, float] | None
) -> tuple[float, float, float, float]:
    """Return the rms error [% of the stroke], shares of held intervals and of misses, and what the ruler reads then."""
    top = min(0.024, round(0.9 * model.quantity_max, 3))
    with opened(wire, seed, settings) as rig:
        found = mw.control(rig, model, mw.staircase(0.012, top, (top - 0.012) / 4), known_strain=known)
        strain = found["displacement_m"] / rig.leg_length_m
    time_s = found["time_s"] - found["time_s"][0]
    counts = (found["valid"] > 0.0) & (time_s > KNOWN_AT_S + SETTLED_S)
    error = (found["estimated_strain"] - strain)[counts]
    held = np.abs(error) <= 1.96 * found["estimate_std"][counts]
    rms_pct = 100.0 * float(np.sqrt(np.mean(error**2))) / model.stroke
    missed = float("known strain missed" in str(found.metadata.get("health", "")))
    return rms_pct, float(held.mean()), missed, float(np.interp(KNOWN_AT_S, time_s, strain))


def main() -> int:
    quick = "--quick" in sys.argv
    worst = 1.0
    print("wire           changed        without: rms %, held   with it: rms %, held, missed", flush=True)
    for wire in WIRES[:1] if quick else WIRES:
        with opened(wire, FIT_SEED, {}) as rig:
            loop = mw.characterize(rig, minor_loop=False)
        model = mw.fit(loop)
        stated = {"ambient_temperature_k": 295.15, **{k: v for k, v in loop.metadata.items() if isinstance(v, float)}}
        cases = [(name, model, {key: by * stated[key] for key, by in rig.items()}) for name, rig in RIGS.items()]
        for name, by in RESISTANCES.items():
            ohms = {key: getattr(model, key) / by for key in ("resistance_min_ohm", "resistance_max_ohm")}
            cases.append((name, replace(model, **ohms), {}))
        for name, used, settings in cases:
            rows = []
            for seed in SEEDS[:1] if quick else SEEDS:
                rms_pct, held, _, known = run(used, wire, seed, settings, None)
                rows.append([rms_pct, held, *run(used, wire, seed, settings, (known, KNOWN_AT_S))[:3]])
            mean = np.mean(rows, axis=0)
            noticed = [row[3] for row in rows if row[4]]
            worst = min(worst, float(np.mean(noticed))) if noticed else worst
            print("{:14} {:13} {:8.2f} {:10.0%} {:15.2f} {:9.0%} {:6.0%}".format(wire, name, *mean), flush=True)
    holds = worst >= MIN_HELD
    print(f"held where it was missed, worst row: {worst:.0%} (bar {MIN_HELD:.0%}): {'holds' if holds else 'FAILS'}")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
