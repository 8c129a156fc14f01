"""Defects that the loop shows, at the sizes of the test bed: ``fit`` and ``estimate`` name them, and nothing else.

What counts as one was chosen on the draws of seeds 1 to 12; those here had no part in it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.labs.loops import (
    LOOPS,
    Defect,
    Loop,
    coarse,
    coil,
    dead_zone,
    late_motion,
    loop,
    noise_of_the_current,
    short_of_the_start,
    step_with_the_current,
)
from tests.labs.test_fits_that_do_not_hold import recorded

import musclewire as mw
from musclewire.errors import FitRejectedError, RecordingError
from musclewire.identify import estimate, fit
from musclewire.sensing import SensingModel
from musclewire.signals import Recording

# What is said of each defect begins so.
NAMED: dict[Defect, str] = {
    noise_of_the_current: "noise at low current drowns the swing",
    step_with_the_current: "the resistance jumps by",
    dead_zone: "the resistance hardly changes",
    short_of_the_start: "cooling ends",
    late_motion: "two clocks were joined",
}
# Standard deviations [s] of the delay with which two instruments were joined: of two that 50 ms may lie between, with 0
# for one that is not stated, and of sound ones.
LATE_S, SOUND_S = (0.0, 0.025, 0.05), (1e-4, 1e-3)
MOST = [10, pytest.param(100, marks=pytest.mark.slow), pytest.param(200, marks=pytest.mark.full)]


def drawn(number: int, defect: Defect | None) -> tuple[Recording, str, bool]:
    """Return a drawn loop of 20 to 300 points with a defect, its name, and whether its wire is a coil."""
    random = np.random.default_rng([57, number])
    every, name = int(random.integers(1, 4)), str(random.choice(LOOPS))
    columns: Loop = {key: values[::every] for key, values in loop(name).items()}
    coiled = random.random() < 0.3
    # To a staircase of minutes 50 ms are nothing.
    seldom = random.random() < 0.3 and defect is not late_motion
    made = [one for one, there in ((defect, defect), (coil, coiled), (coarse, seldom)) if one and there]
    for one in made:
        columns = one(columns, random)
    return joined(recorded(columns, random), number, defect), name, coiled


def joined(recording: Recording, number: int, defect: Defect | None) -> Recording:
    """Return a recording as if joined from two instruments: every late one, and every other of the others."""
    if defect is not late_motion and number % 2:
        return recording
    random = np.random.default_rng([58, number])
    std_s = float(random.choice(LATE_S) if defect is late_motion else random.uniform(*SOUND_S))
    stated = {"join_delay_std_s": std_s} if std_s else {"join_how": "by their clocks, which count from one moment"}
    return recording.with_metadata({"join_delay_s": 0.2, **stated})


@cache
def model_of(name: str, coiled: bool) -> SensingModel:
    """Return the model of a sound loop, or of its coil."""
    random = np.random.default_rng(57)
    columns: Loop = loop(name)
    return fit(recorded(coil(columns, random) if coiled else columns, random), quantity="displacement")


def said(warnings: Callable[[], tuple[str, ...]]) -> str:
    """Return the warnings, or why there are none."""
    try:
        return "\n".join(warnings())
    except (RecordingError, FitRejectedError) as error:
        return str(error)


def counted(count: int, defect: Defect | None) -> dict[str, Counter[str]]:
    """Return how often fit and estimate name each defect in drawn recordings; the shares are printed."""
    found: dict[str, Counter[str]] = {"fit": Counter(), "estimate": Counter()}
    for number in range(count):
        recording, name, coiled = drawn(number, defect)
        model = model_of(name, coiled)
        texts = {
            "fit": said(lambda here=recording: fit(here, quantity="displacement", order=3).warnings),
            "estimate": said(lambda here=recording, by=model: estimate(by, here).warnings),
        }
        for command, text in texts.items():
            found[command].update(begins for begins in NAMED.values() if begins in text)
    print(defect.__name__ if defect else "sound", count, {name: dict(shares) for name, shares in found.items()})
    return found


@pytest.mark.parametrize("count", MOST)
@pytest.mark.parametrize("defect", NAMED, ids=lambda defect: defect.__name__)
def test_a_defect_is_named_by_fit_and_by_estimate_and_no_other_one(defect: Defect, count: int) -> None:
    for found in counted(count, defect).values():
        assert found.pop(NAMED[defect], 0) >= 0.95 * count
        assert max(found.values(), default=0) <= 0.01 * count


@pytest.mark.parametrize("count", MOST)
def test_a_sound_loop_is_not_warned_of(count: int) -> None:
    for found in counted(count, None).values():
        assert found.total() <= 0.01 * count


# A pretension in proportion to the section: what the maker's door has for 0.10 mm, on both legs of the bench's V.
@pytest.mark.parametrize(
    ("wire", "pretension"),
    [
        pytest.param("", "", marks=pytest.mark.slow),
        ("flexinol-0.10-lt", "1.3"),
        ("flexinol-0.15-lt", "2.9"),
        ("flexinol-0.25-lt", "8.1"),
    ],
)
def test_a_loop_of_a_simulated_rig_is_not_warned_of(wire: str, pretension: str, tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(f'kind = "simulated"\nwire = "{wire}"\npretension = "{pretension} N"\n', "utf-8")
    with mw.open_rig(file if wire else "finger") as rig:
        recording = mw.characterize(rig)
    model = fit(recording)
    text = "\n".join((*model.warnings, *estimate(model, recording).warnings))
    assert not [begins for begins in NAMED.values() if begins in text]


# Steps of a column as a part of its usual reading: two decimals of a small current, and what ten bits have.
@pytest.mark.parametrize(("low", "high", "named"), [(0.08, 0.16, True), (1e-4, 0.02, False)])
def test_a_column_of_coarse_steps_is_named_and_no_drive_is_asked_for(low: float, high: float, named: bool) -> None:
    for number in range(60):
        random = np.random.default_rng([63, number])
        found = loop(LOOPS[number % 3])
        column = str(random.choice(["wire_current_a", "wire_voltage_v"]))
        step = float(np.median(found[column])) * random.uniform(low, high)
        rounded = {**found, column: np.maximum(np.round(found[column] / step), 1.0) * step}
        kept = ("time_s", "wire_voltage_v", "wire_current_a", "displacement_m")
        recording = Recording({name: rounded[name] for name in kept}, {})
        text = said(lambda here=recording: fit(here, quantity="displacement", order=3).warnings)
        assert (f"{column} is recorded in steps of {step:.3g}" in text) == named, (number, text)
        assert not (named and "raise the drive" in text)


def test_a_current_that_is_set_in_steps_is_not_coarse() -> None:
    for name in LOOPS:
        found = loop(name)
        levels = np.linspace(found["wire_current_a"].min(), found["wire_current_a"].max(), 8)
        half = found["wire_current_a"].size // 2
        rows = [np.abs(found["wire_current_a"][:half] - level).argmin() for level in levels]
        rows += [half + np.abs(found["wire_current_a"][half:] - level).argmin() for level in levels[::-1]]
        set_a = {"wire_current_a": np.append(levels, levels[::-1]), "time_s": 10.0 * np.arange(16)}
        columns = {column: found[column][rows] for column in ("wire_resistance_ohm", "displacement_m")} | set_a
        columns["wire_voltage_v"] = columns.pop("wire_resistance_ohm") * columns["wire_current_a"]
        recording = Recording(columns, {})
        text = said(lambda here=recording: fit(here, quantity="displacement", order=3).warnings)
        assert "is recorded in steps" not in text
