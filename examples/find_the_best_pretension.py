"""Sweep the pretension of a 125 um wire and find where heating and cooling agree best."""

import matplotlib

import musclewire as mw

matplotlib.use("Agg")

with mw.open_rig("simulated", wire="paper-125um") as rig:
    sweep = mw.pretension_sweep(rig, [1.7, 2.4, 3.2, 4.0, 4.7], cycles=1)

for row in sweep.rows:
    print(f"{row.pretension_n:5.2f} N   gap {row.strain_gap_pct:6.3f} %   stroke {row.stroke_pct:5.2f} %")
for failure in sweep.failures:
    print(f"not usable: {failure}")
if sweep.best is not None:
    print(f"best: {sweep.best.pretension_n:.2f} N")
print(sweep.advice)

axes = sweep.plot()
print(f"the figure shows {len(axes.get_lines())} lines; save it with axes.figure.savefig(...)")
