"""Cycle a new wire until its loop repeats, fit it, and re-anchor the model at a later start, all on one wire."""

import musclewire as mw
from musclewire.rigs.configuration import RigConfiguration

with mw.open_rig(RigConfiguration(new_wire=True)) as rig:
    training = mw.train(rig)
    for cycle in training.cycles:
        moved = "" if cycle.change is None else f"moved by {100 * cycle.change:.2f} %"
        print(f"cycle {cycle.number:2}: R {cycle.resistance_min_ohm:.3f} to {cycle.resistance_max_ohm:.3f} ohm {moved}")
    print("settled" if training.settled else "not settled")

    model = mw.fit(mw.characterize(rig))
    start = mw.recalibrate(rig, model)
    print(
        f"R_min moved by {start.resistance_min_moved_ohm:+.4f} ohm, R_max by {start.resistance_max_moved_ohm:+.4f} ohm"
    )
    run = mw.control(rig, start.model, mw.staircase())
print(run.metrics)
