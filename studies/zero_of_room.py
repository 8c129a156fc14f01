"""What a room 15 K warmer or colder costs a loop whose strain counts from today's cold wire, and what is left of it.

Each wire of ours is characterized in a room of 22 C, its loop runs in others, and its instrument counts from the wire
as it is cold there. `kept`: estimates count from the characterization's cold wire, as by default; `today`: by
`control --zero-from today`. The part of 0.7 in src/musclewire/identify/_zero_of_room.py was chosen on seeds 3 and 5.
Bar: on the paper's wire of 100 um the mean over the seeds of the mean step error is at most 1.5 % at +-15 K. Exit 1
where it fails.

    python studies/zero_of_room.py [--quick]     four wires, seeds 11 to 15; or the paper's wire, seed 11
"""

from __future__ import annotations

import sys

import numpy as np

import musclewire as mw
from musclewire import RigConfiguration
from musclewire.rigs import GuardedRig

OURS = "paper-100um"
WIRES, SEEDS = (OURS, "paper-125um", "paper-200um", "flexinol-0.15-lt"), range(11, 16)
ROOM_K, DIFFERENCES_K = 295.15, (-15.0, -4.0, 4.0, 15.0)
BAR_PCT, FAR_K, SETTLED_S = 1.5, 15.0, 2.0


def opened(wire: str, room_k: float, seed: int) -> GuardedRig:
    """Return the simulated rig with a wire in a room."""
    return mw.open_rig(RigConfiguration(wire=wire, settings={"ambient_temperature_k": room_k}), seed=seed)


def run(model: mw.SensingModel, wire: str, room_k: float, zero_from: str, seed: int) -> tuple[float, float, float]:
    """Return mean step error [% of target], mean error [% of the stroke] and share of held intervals of a loop."""
    with opened(wire, room_k, seed) as rig:
        found = mw.control(rig, model, zero_from=zero_from)
        leg_m = rig.leg_length_m
    counts = (found["valid"] > 0.0) & (found["time_s"] > SETTLED_S)
    error = (found["estimated_strain"] - found["displacement_m"] / leg_m)[counts]
    held = np.abs(error) <= 1.96 * found["estimate_std"][counts]
    return float(found.metrics.mae_mean_pct or np.nan), 100.0 * float(error.mean()) / model.stroke, float(held.mean())


def main() -> int:
    quick = "--quick" in sys.argv
    seeds, worst = (SEEDS[:1] if quick else SEEDS), 0.0
    print("wire              room      kept: MAE %, bias %, held      today: MAE %, bias %, held", flush=True)
    for wire in WIRES[:1] if quick else WIRES:
        models = {}
        for seed in seeds:
            with opened(wire, ROOM_K, seed) as rig:
                models[seed] = mw.fit(mw.characterize(rig, minor_loop=False))
        left = [100.0 * FAR_K * float(model.wire["cold_contraction_per_k"]) / model.stroke for model in models.values()]
        print(f"{wire:16}  cooled to +{FAR_K:.0f} K the wire keeps {np.mean(left):.1f} % of its stroke", flush=True)
        for warmer_k in DIFFERENCES_K:
            means = {}
            for zero_from in ("kept", "today"):
                runs = [run(model, wire, ROOM_K + warmer_k, zero_from, 100 + seed) for seed, model in models.items()]
                means[zero_from] = np.mean(runs, axis=0)
            if wire == OURS and abs(warmer_k) == FAR_K:
                worst = max(worst, float(means["today"][0]))
            kept, today = ("{:6.2f} {:+6.2f} {:6.0%}".format(*means[name]) for name in ("kept", "today"))
            print(f"{wire:16}  {warmer_k:+4.0f} K    {kept}             {today}", flush=True)
    holds = worst <= BAR_PCT
    print(f"{OURS} at +-{FAR_K:.0f} K: {worst:.2f} % (bar {BAR_PCT:g} %): {'holds' if holds else 'FAILS'}")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
