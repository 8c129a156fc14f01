"""Cycle a new wire until its loop repeats, fit it, and make a home move at a later start, all on one wire."""

import musclewire as mw
from musclewire import RigConfiguration

with mw.open_rig(RigConfiguration(new_wire=True)) as rig:
    training = mw.train(rig)
    for cycle in training.cycles:
        moved = "" if cycle.change is None else f"moved by {100 * cycle.change:.2f} %"
        print(f"cycle {cycle.number:2}: R {cycle.resistance_min_ohm:.3f} to {cycle.resistance_max_ohm:.3f} ohm {moved}")
    print("settled" if training.settled else "not settled")

    model = mw.fit(mw.characterize(rig))
    found = mw.home(rig, model, ambient_k=295.15)
    print(
        f"at B the resistance moved by {found.resistance_max_moved_ohm:+.4f} +- "
        f"{found.resistance_max_moved_std_ohm:.4f} ohm; corrected: {found.home.corrected}"
    )
    run = mw.control(rig, found.model, mw.staircase())
print(run.metrics)
