"""The same characterization, fit and control on whatever a wire pulls: no experiment knows what that is.

How well it goes is the wire's matter, not the experiment's: the further heating and cooling are apart on a load
(Eq. 2), the further its average is off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from musclewire.controllers import staircase
from musclewire.experiment import characterize, control
from musclewire.identify import fit
from musclewire.rigs import GuardedRig, RigConfiguration, open_rig

SPRING = {"part": "spring", "stiffness": "386.2 N/m"}
LOADS = {
    "weight and spring": [{"part": "weight", "force": "0.5 N"}, SPRING],
}


class Job(NamedTuple):
    """What is sensed, how far it goes at least, and how far off the mean step may end, in percent of its target."""

    load: str
    quantity: str
    min_range: float
    max_mae_pct: float


# Strain is sensed from B on: all of the stroke but the 15 % of segment A-B (Fig. 3(b)), which no polynomial covers. A
# wire's own stroke on these loads is at least 3.3 %.
SENSED_STRAIN = 0.85 * 0.033
JOBS = [
    Job("finger", "displacement", 5e-3, 5.0),
    Job("finger", "strain", SENSED_STRAIN, 5.0),
    Job("weight and spring", "strain", 0.03, 5.0),
]


def rig(load: str) -> GuardedRig:
    if load == "finger":
        return open_rig("finger")
    return open_rig(RigConfiguration(wire="finger-100um", bench="finger", load=LOADS[load]))  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize("job", JOBS, ids=lambda job: f"{job.load}, {job.quantity}")
def test_characterize_fit_and_control_run_on_any_load(job: Job) -> None:
    with rig(job.load) as opened:
        loop = characterize(opened, cycles=2, period_s=60.0)
        model = fit(loop, quantity=job.quantity)
        low, high = model.quantity_min, model.quantity_max
        start, stop = low + 0.45 * (high - low), low + 0.75 * (high - low)
        run = control(opened, model, staircase(start, stop, (stop - start) / 2.0, hold_s=4.0))
    assert model.quantity == job.quantity
    assert high - low > job.min_range
    assert run.metrics.valid_share == 1.0
    assert run.metrics.mae_mean_approached_pct is not None
    assert run.metrics.mae_mean_approached_pct < job.max_mae_pct


@pytest.mark.slow
def test_the_displacement_of_a_finger_is_its_endpoints_and_both_are_recorded() -> None:
    with open_rig("finger") as opened:
        loop = characterize(opened, cycles=1, period_s=20.0)
    endpoint, connector = loop["endpoint_displacement_m"], loop["displacement_m"]
    assert endpoint.max() > 4.0 * connector.max()
    model = fit(loop, quantity="displacement")
    # The polynomials may end a little beyond what was seen.
    assert model.quantity_max == pytest.approx(float(endpoint.max()), rel=0.1)
    assert "endpoint_force_n" not in loop.columns or np.isnan(loop["endpoint_force_n"]).all()


def test_what_pushes_a_fingers_endpoint_back_is_recorded_where_it_meets_something() -> None:
    parts = [
        {"part": "pretensioner", "stiffness": "386.2 N/m"},
        {"part": "finger", "finger": "lan-fan-2010"},
        {"part": "contact", "stiffness": "200 N/m", "clearance": "2 mm"},
    ]
    with open_rig(RigConfiguration(wire="finger-100um", bench="finger", load=parts)) as opened:  # type: ignore[arg-type]
        loop = characterize(opened, cycles=1, period_s=20.0)
    touching = loop["endpoint_displacement_m"] > 2.05e-3
    assert touching.sum() > 20
    pressed = 200.0 * (loop["endpoint_displacement_m"][touching] - 2e-3)
    # Noise of the laser times the foam's stiffness, and of the cell.
    assert loop["endpoint_force_n"][touching] == pytest.approx(pressed, abs=0.02)
    assert np.abs(loop["endpoint_force_n"][loop["endpoint_displacement_m"] < 1.9e-3]).max() < 0.02
