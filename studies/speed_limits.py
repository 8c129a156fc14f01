"""Speed limits said beforehand against what a run reaches: sines of several frequencies on the simulated rig.

python studies/speed_limits.py
"""

from __future__ import annotations

import math

import numpy as np

import musclewire as mw

MIDDLE, AMPLITUDE, LEG_LENGTH_M = 0.0225, 0.0095, 0.07
FREQUENCIES_HZ = (0.05, 0.2, 0.5, 1.0, 2.0)


def main() -> None:
    """Print asked, possible and reached amplitude at each frequency, and the warnings at 0.5 Hz."""
    with mw.open_rig("simulated", seed=1) as rig:
        slow = mw.characterize(rig, minor_loop=False)
    model = mw.fit(slow)
    gains = mw.tune(model, slow).settings
    print(f"asked {100 * AMPLITUDE:.2f} % about {100 * MIDDLE:.2f} %")
    print("frequency [Hz]  possible [%]  reached by a run [%]")
    for frequency_hz in FREQUENCIES_HZ:
        time_s = np.arange(0.0, max(3.0 / frequency_hz, 12.0), 0.05)
        reference = mw.sampled_reference(time_s, MIDDLE + AMPLITUDE * np.sin(2.0 * math.pi * frequency_hz * time_s))
        with mw.open_rig("simulated", seed=2) as rig:
            said = mw.speed_limits(rig, model, reference)
            run = mw.control(rig, model, reference, controller="inverse-model", settings=gains)
        settled = run["displacement_m"][len(run) // 2 :] / LEG_LENGTH_M
        print(f"{frequency_hz:14.2f}  {100 * said.possible_amplitude:12.2f}  {50 * float(np.ptp(settled)):20.2f}")
        if frequency_hz == 0.5:
            shown = said
    print(shown)


if __name__ == "__main__":
    main()
