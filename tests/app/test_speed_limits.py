"""Speed limits are said before a wire is heated, and the simulated wire keeps to them."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import musclewire as mw
from musclewire.controllers import SampledReference
from musclewire.sensing import SensingModel

MIDDLE, AMPLITUDE = 0.0225, 0.0095


class Wire(NamedTuple):
    model: SensingModel
    settings: Any


@pytest.fixture(scope="module")
def wire() -> Wire:
    with mw.open_rig("simulated", seed=4) as rig:
        slow = mw.characterize(rig)
    model = mw.fit(slow)
    return Wire(model, mw.tune(model, slow).settings)


def sine(frequency_hz: float) -> SampledReference:
    time_s = np.arange(0.0, max(3.0 / frequency_hz, 12.0), 0.05)
    return mw.sampled_reference(time_s, MIDDLE + AMPLITUDE * np.sin(2.0 * math.pi * frequency_hz * time_s))


@pytest.mark.slow
@pytest.mark.parametrize("frequency_hz", [0.05, 0.5, 1.0])
@pytest.mark.parametrize("by_gains", [False, True])
def test_a_run_reaches_the_amplitude_that_was_said_before(wire: Wire, frequency_hz: float, by_gains: bool) -> None:
    """The bar: within 30 % of what a loop by the inverse of its model reaches."""
    reference, gains = sine(frequency_hz), wire.settings
    with mw.open_rig("simulated", seed=5) as rig:
        said = mw.speed_limits(rig, wire.model, reference, settings=gains if by_gains else None)
        run = mw.control(rig, wire.model, reference, controller="inverse-model", settings=gains)
    settled = run["displacement_m"][len(run) // 2 :] / 0.07
    reached = 0.5 * float(np.ptp(settled))
    assert said.possible_amplitude == pytest.approx(reached, rel=0.3)
    assert bool(said.findings) is (frequency_hz > 0.1)
    assert run.metadata.get("speed_limits", "").startswith("the reference") is (frequency_hz > 0.1)


def test_control_warns_before_it_heats_and_in_its_answer(
    wire: Wire, tmp_path: Path, musclewire: Callable[..., Any]
) -> None:
    model_file, reference_file = tmp_path / "model.json", tmp_path / "target.csv"
    wire.model.save(model_file)
    fast = sine(1.0)
    rows = "\n".join(f"{t:.2f},{x:.6f}" for t, x in zip(fast.time_s, fast.target, strict=True))
    reference_file.write_text(f"time_s,target_strain\n{rows}\n", "utf-8")
    given = ("control", "simulated", model_file, "--reference", reference_file)
    answer = musclewire(*given, "--json").json
    assert any("faster than the wire cools" in text for text in answer["warnings"])
    assert answer["speed_limits"]["possible_amplitude"] < answer["speed_limits"]["asked_amplitude"]
    assert answer["speed_limits"]["help"]["heat_loss"] > 1.0
    shown = musclewire(*given).err
    assert shown.index("faster than the wire cools") < shown.index("Closed loop")
