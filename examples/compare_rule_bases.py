"""Run the staircase with each rule base on the same wire, and compare the errors of its steps after the approach."""

import musclewire as mw
from musclewire import rule_base_names

with mw.open_rig("simulated") as rig:
    model = mw.fit(mw.characterize(rig))

print(f"{'rule base':20} {'largest MAE':>12} {'mean MAE':>12} {'first step from its target on':>30}")
for name in rule_base_names():
    with mw.open_rig("simulated") as rig:  # a fresh wire for each, so that none profits from the one before
        run = mw.control(rig, model, mw.staircase(), settings=mw.FuzzyPidSettings(rule_base=name))
    found, first_pct = run.metrics, run.metrics.steps[0].mae_pct
    largest_pct, mean_pct = found.mae_max_approached_pct, found.mae_mean_approached_pct
    print(f"{name:20} {largest_pct:10.3f} % {mean_pct:10.3f} % {first_pct:28.3f} %")
