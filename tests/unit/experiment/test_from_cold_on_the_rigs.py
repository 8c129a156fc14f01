"""The default loop from cold on the rigs that ship with musclewire: medians over 20 seeds, nothing chosen.

What misses its bar stands here as an expected failure, with the figure that was measured.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

import musclewire as mw
from musclewire.experiment import control_many
from musclewire.rigs import RigConfiguration, rig_names

pytestmark = pytest.mark.slow
SEEDS = range(501, 521)
RIGS: dict[str, tuple[str | RigConfiguration, str]] = {
    "100 um": (RigConfiguration(), "strain"),
    "125 um": (RigConfiguration(wire="paper-125um"), "strain"),
    "finger": ("finger", "displacement"),
    "flexinol-0.15-lt": (RigConfiguration(wire="flexinol-0.15-lt", settings={"pretension_n": 2.5}), "strain"),
    # Comes with the part that grips.
    **({"gripper": ("gripper", "displacement")} if "gripper" in rig_names() else {}),
}


class Found(NamedTuple):
    """Medians of first, largest and mean step error [% of the target], drive swings at each hold [V], and findings."""

    first_pct: float
    largest_pct: float
    mean_pct: float
    swings_v: np.ndarray
    health: str


@cache
def found_on(name: str) -> Found:
    """Return what twenty loops on a rig come to, with one model of it."""
    rig, quantity = RIGS[name]
    with mw.open_rig(rig, seed=1) as opened:
        model = mw.fit(mw.characterize(opened), quantity=quantity)
    # Two wires have no compiled loop.
    runs = control_many(rig, model, seeds=SEEDS, keep_recordings=True, in_python=name == "gripper")
    assert not runs.failed
    swings = []
    for outcome in runs.outcomes:
        assert outcome.run is not None
        assert outcome.run.metadata["controller"] == "inverse-model"
        time_s, drive_v = outcome.run["time_s"] - outcome.run["time_s"][0], outcome.run["drive_voltage_v"]
        for index in range(len(runs.steps)):
            last = (time_s >= 6.0 * index + 3.0) & (time_s < 6.0 * index + 5.9)
            swings.append(float(np.ptp(drive_v[last])))
    medians = (float(np.median(row)) for row in (runs.mae_pct[:, 0], runs.mae_max_pct, runs.mae_mean_pct))
    health = "; ".join(str(one.run.metadata.get("health", "")) for one in runs.outcomes if one.run is not None)
    return Found(*medians, np.array(swings), health)


# First, largest and mean step error [%].
BARS_PCT = {
    "100 um": (1.5, 2.0, 0.6),
    "125 um": (1.5, 2.0, 0.9),
    "finger": (5.0, 5.0, 1.1),
    "flexinol-0.15-lt": (5.0, 5.5, 2.2),
    "gripper": (12.0, np.inf, 3.0),
}


@pytest.mark.parametrize("name", list(RIGS))
def test_the_default_loop_follows_from_cold(name: str) -> None:
    found, (first_pct, largest_pct, mean_pct) = found_on(name), BARS_PCT[name]
    assert found.first_pct <= first_pct
    assert found.largest_pct <= largest_pct
    assert found.mean_pct <= mean_pct


@pytest.mark.parametrize("name", list(RIGS))
def test_what_a_sound_wire_has_not_is_not_named(name: str) -> None:
    causes = ("bad contact", "changed load or resistance", "overshoot")
    assert not [one for one in causes if one in found_on(name).health]


SWINGS = pytest.mark.xfail(
    strict=True, reason="16 % of the holds swing by more than 0.5 V, up to 1.2 V, with the gains of the wire's model"
)


@pytest.mark.parametrize("name", ["100 um", "125 um", "finger", pytest.param("flexinol-0.15-lt", marks=SWINGS)])
def test_the_drive_rests_at_hold(name: str) -> None:
    swings_v = found_on(name).swings_v
    assert float(np.mean(swings_v > 0.5)) <= 0.05
    assert float(swings_v.max()) <= 1.0


def test_in_a_draught_the_default_is_no_worse_than_the_papers_loop_after_its_approach() -> None:
    with mw.open_rig("simulated", seed=1) as rig:
        model = mw.fit(mw.characterize(rig))
    draught = RigConfiguration.model_validate({"surroundings": {"draught": 0.25}})
    ours, papers = (control_many(draught, model, seeds=[1], controller=name) for name in (None, "fuzzy-pid"))
    assert ours.metrics[0].mae_mean_pct <= papers.metrics[0].mae_mean_approached_pct  # type: ignore[operator]
