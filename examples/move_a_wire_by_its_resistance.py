"""Characterize a wire, fit its self-sensing model, and move it with no sensor but its own resistance."""

import musclewire as mw

with mw.open_rig("simulated") as rig:  # or the path of a TOML rig file
    loop = mw.characterize(rig)
    model = mw.fit(loop)
    run = mw.control(rig, model, mw.staircase())
print(run.metrics)
