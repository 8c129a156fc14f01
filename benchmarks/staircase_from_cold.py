"""The paper's staircase from cold on the rigs that ship with musclewire: mean error, false trips, what was held back.

    python -m benchmarks.staircase_from_cold [--seeds 100] [--only gripper] [--quick]

On each rig a model of one slow loop, then loops with nothing chosen, each with a seed of its own. A line a rig: mean
and median over the seeds of the mean step error (Eq. 7, in percent of the target), the worst seed, how many runs a
fault ended, and in how many the protection held samples back. The bar is no fault; exit code 1 beyond.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np

import musclewire as mw
from musclewire.rigs import RigConfiguration

SEEDS, QUICK_SEEDS, FIRST = 100, 5, 501
FLEXINOL = RigConfiguration(wire="flexinol-0.15-lt", settings={"pretension_n": 2.5})
RIGS: dict[str, tuple[str | RigConfiguration, str]] = {
    "simulated": ("simulated", "strain"),
    "finger": ("finger", "displacement"),
    "flexinol-0.15-lt": (FLEXINOL, "strain"),
    "gripper": ("gripper", "displacement"),
}


def line_of(name: str, seeds: int) -> tuple[str, int]:
    """Return a rig's line, and how many of its runs failed."""
    rig, quantity = RIGS[name]
    with mw.open_rig(rig, seed=1) as opened:
        model = mw.fit(mw.characterize(opened, minor_loop=False), quantity=quantity)
    # Two wires have no compiled loop.
    runs = mw.control_many(
        rig, model, seeds=range(FIRST, FIRST + seeds), keep_recordings=True, in_python=name == "gripper"
    )
    mean_pct = np.array([one.mae_mean_pct for one in runs.metrics])
    held = [one for one in runs.outcomes if one.run is not None and "held_back" in one.run.metadata]
    ended = sorted({one.ended for one in runs.failed})
    worst = runs.outcomes[int(np.argmax(runs.mae_mean_pct))].seed if not runs.failed else runs.failed[0].seed
    said = (
        f"{name:17s} mean {mean_pct.mean():.3f} %  median {np.median(mean_pct):.3f} %  worst {mean_pct.max():.3f} % "
        f"(seed {worst})  {len(runs.failed)} of {seeds} ended by a fault{''.join(' ' + one for one in ended)}  "
        f"{len(held)} held back"
    )
    return said, len(runs.failed)


def main() -> int:
    """Run, print, and return the exit code."""
    parser = argparse.ArgumentParser(description="The staircase from cold, over seeds.")
    parser.add_argument("--seeds", type=int, default=None)
    parser.add_argument("--only", choices=list(RIGS), default=None)
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    failed = 0
    for name in RIGS if given.only is None else [given.only]:
        said, trips = line_of(name, given.seeds or (QUICK_SEEDS if given.quick else SEEDS))
        print(said, flush=True)
        failed += trips
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
