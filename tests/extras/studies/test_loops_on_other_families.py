"""The inverse of the model on wires that are not our simulator's: no limit cycle, and what is wrong is named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.places import EXAMPLES

import musclewire as mw
from musclewire.experiment import ControlRun, staircase_within

HOLD_S, SWING_V, LONGEST_CYCLE_S = 6.0, 0.5, 3.0
MAX_MEAN_PCT = 1.6


def rig_file(plant: str, seed: int, **keys: str) -> Path:
    """Write a rig file of a plant next to its module, with more keys."""
    lines = [*(EXAMPLES / "plants" / f"{plant}.toml").read_text("utf-8").splitlines(), f"seed = {seed}"]
    name = "_".join(one.replace(" ", "").replace(".", "p") for one in keys.values())
    path = EXAMPLES / "plants" / f"drawn_{plant}_{seed}_{name}.toml"
    path.write_text("\n".join([*lines, *(f'{key} = "{value}"' for key, value in keys.items())]) + "\n", "utf-8")
    return path


def opened(plant: str, seed: int, **keys: str) -> mw.Rig:
    """Open a plant."""
    path = rig_file(plant, seed, **keys)
    try:
        return mw.open_rig(path)
    finally:
        path.unlink()


def loop_on(plant: str, **keys: str) -> ControlRun:
    """Return the paper's staircase from cold, with the gains of the plant's own slow loop."""
    return loops_on(plant, 1, **keys)[0]


def loops_on(plant: str, count: int, **keys: str) -> list[ControlRun]:
    """Return so many of these loops, each with noise of its own."""
    with opened(plant, 1, **keys) as rig:
        slow = mw.characterize(rig)
    model = mw.fit(slow)
    gains = mw.tune(model, slow).settings
    runs = []
    for seed in range(501, 501 + count):
        with opened(plant, seed, **keys) as rig:
            reference = staircase_within(model)
            runs.append(mw.control(rig, model, reference, controller="inverse-model", settings=gains))
    return runs


def longest_cycle_s(run: ControlRun) -> float:
    """Return for how long the drive swung to and fro by more than half a volt while one target held."""
    time_s, drive_v = run["time_s"] - run["time_s"][0], run["drive_voltage_v"]
    longest_s = 0.0
    for number in range(len(run.metrics.steps)):
        rows = np.flatnonzero((time_s >= number * HOLD_S + 1.0) & (time_s < (number + 1) * HOLD_S - 1e-6))
        turns = turns_s(time_s[rows], drive_v[rows])
        longest_s = max(longest_s, turns[-1] - turns[0] if len(turns) > 2 else 0.0)
    return longest_s


def turns_s(time_s: np.ndarray, drive_v: np.ndarray) -> list[float]:
    """Return when the drive turned after a swing."""
    extreme_v, way, found = drive_v[0], 0.0, []
    for at_s, volts in zip(time_s, drive_v, strict=True):
        away_v = volts - extreme_v
        if away_v * way > 0.0:
            extreme_v = volts
        elif abs(away_v) > SWING_V:
            found += [float(at_s)] if way else []
            way, extreme_v = float(np.sign(away_v)), volts
    return found


def drawn(count: int) -> list[tuple[str, float, float]]:
    """Draw plants with their dead time [s] and hysteresis [K]."""
    chosen = np.random.default_rng(7)
    plants = ("liang_rogers", "duhem")
    return [(plants[k % 2], chosen.uniform(0.0, 0.2), chosen.uniform(5.0, 25.0)) for k in range(count)]


# With more than 0.12 s of dead time in addition to that of the samples the drive swings for as long as a target holds.
TOO_LATE_S = 0.12
# Beyond this hysteresis [K] the limit cycle on Liang-Rogers is longer than it may be with less dead time, too.
WIDE_K = 22.0


def as_it_is(one: tuple[str, float, float]) -> Any:
    """Return a drawn plant as a parameter, marked where its loop swings."""
    swings = "the drive swings for 4.4 to 4.5 s of 5 at a hold: nothing lowers the controller's gain any more"
    longer = "the drive swings for 3.6 s of 5 at a hold, in the widest gap: the heat loss follows the delay"
    why = swings if one[1] > TOO_LATE_S else longer if one[0] == "liang_rogers" and one[2] > WIDE_K else ""
    return pytest.param(*one, marks=[pytest.mark.xfail(strict=True, reason=why)] if why else [])


@pytest.mark.slow
@pytest.mark.parametrize("plant", ["liang_rogers", "duhem"])
def test_a_wire_of_another_family_is_held_quietly_from_cold(plant: str) -> None:
    runs = loops_on(plant, 5)
    assert [longest_cycle_s(run) for run in runs] == [0.0] * 5
    assert np.median([run.metrics.mae_mean_pct for run in runs]) < MAX_MEAN_PCT


@pytest.mark.slow
@pytest.mark.parametrize(("plant", "dead_time_s", "hysteresis_k"), [as_it_is(one) for one in drawn(6)])
def test_dead_time_and_a_wide_gap_give_no_limit_cycle(plant: str, dead_time_s: float, hysteresis_k: float) -> None:
    run = loop_on(plant, dead_time=f"{dead_time_s:.3f} s", hysteresis=f"{hysteresis_k:.1f} K")
    assert longest_cycle_s(run) <= LONGEST_CYCLE_S


@pytest.mark.slow
def test_a_drive_that_swings_for_its_dead_time_is_named() -> None:
    plant, dead_time_s, hysteresis_k = next(one for one in drawn(6) if one[1] > TOO_LATE_S)
    run = loop_on(plant, dead_time=f"{dead_time_s:.3f} s", hysteresis=f"{hysteresis_k:.1f} K")
    assert "oscillation at" in str(run.metadata["health"])


@pytest.mark.slow
@pytest.mark.xfail(
    strict=True,
    reason="the largest drive, 3.6 V and 0.74 W where the highest temperature is that of 0.98 W, is held while the "
    "estimate is 0.3 % strain below the target and the wire at it; saturation, stalled and target missed are named",
)
def test_a_wire_beyond_c_is_not_heated_on_and_on() -> None:
    """Its resistance rises with temperature beyond C: at 48db7c9 the largest drive was held until the target fell."""
    with opened("duhem", 1) as rig:
        slow = mw.characterize(rig)
    model = mw.fit(slow)
    top = round(0.999 * model.quantity_max, 6)
    below = round(0.7 * model.quantity_max, 6)
    gains = mw.tune(model, slow).settings
    with opened("duhem", 501) as rig:
        steps = mw.staircase(below, top, (top - below) / 2.0, hold_s=8.0)
        run = mw.control(rig, model, steps, controller="inverse-model", settings=gains)
        limit_v = rig.maximum_voltage_v
    at_top = (run["target_strain"] > 0.99 * top) & (run["time_s"] > 20.0)
    assert np.all(run["drive_voltage_v"][at_top] < 0.95 * limit_v)


@pytest.mark.full
@pytest.mark.xfail(strict=True, reason="with more than 0.12 s of dead time the drive swings at a hold, as above")
def test_over_sixty_draws_no_limit_cycle_and_what_errs_is_named() -> None:
    unnamed = []
    for plant, dead_time_s, hysteresis_k in drawn(60):
        run = loop_on(plant, dead_time=f"{dead_time_s:.3f} s", hysteresis=f"{hysteresis_k:.1f} K")
        assert longest_cycle_s(run) <= LONGEST_CYCLE_S, (plant, dead_time_s, hysteresis_k)
        mean_pct = run.metrics.mae_mean_pct
        if mean_pct is None or (mean_pct > MAX_MEAN_PCT and not run.metadata.get("health")):
            unnamed.append((plant, round(dead_time_s, 3), round(hysteresis_k, 1), mean_pct))
    if unnamed:
        pytest.xfail(f"{len(unnamed)} of 60 err by more than {MAX_MEAN_PCT} % in the mean without a name: {unnamed}")
