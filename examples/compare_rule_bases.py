"""Run the staircase with each rule base on the same wire, and compare the errors of its steps."""

import musclewire as mw
from musclewire.controllers import rule_base_names

with mw.open_rig("simulated") as rig:
    model = mw.fit(mw.characterize(rig))

print(f"{'rule base':20} {'largest MAE':>12} {'mean MAE':>12}")
for name in rule_base_names():
    with mw.open_rig("simulated") as rig:  # a fresh wire for each, so that none profits from the one before
        run = mw.control(rig, model, mw.staircase(), settings=mw.FuzzyPidSettings(rule_base=name))
    print(f"{name:20} {run.metrics.mae_max_pct:10.3f} % {run.metrics.mae_mean_pct:10.3f} %")
