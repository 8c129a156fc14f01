from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.experiment import characterize
from musclewire.identify import fit
from musclewire.identify._loop_gaps import guide_friction_n
from musclewire.parameters import load_bench
from musclewire.rigs import open_rig
from musclewire.signals import Recording


def loop(friction_n: float, stiffness: float, noise_n: float = 0.0) -> Recording:
    """A wire that contracts by 2 mm and returns, on a spring behind a guide that turns round at once."""
    displacement = 1e-3 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, 801)))
    direction = np.sign(np.gradient(displacement))
    noise = noise_n * np.random.default_rng(1).standard_normal(displacement.size)
    force = 1.9 + stiffness * displacement + friction_n * direction + noise
    return Recording({"time_s": np.arange(801.0), "displacement_m": displacement, "force_n": force}, {})


@given(st.floats(0.0, 0.2), st.floats(50.0, 2000.0))
def test_half_the_difference_of_the_branches_is_the_friction(friction_n: float, stiffness: float) -> None:
    assert guide_friction_n(loop(friction_n, stiffness)) == pytest.approx(friction_n, abs=1e-9)


def test_noise_of_the_load_cell_averages_out() -> None:
    found = guide_friction_n(loop(0.05, 588.6, noise_n=0.005))
    assert found == pytest.approx(0.05, abs=1e-3)


def test_a_recording_without_a_load_cell_cannot_tell() -> None:
    whole = loop(0.05, 588.6)
    assert guide_friction_n(Recording({k: whole[k] for k in ("time_s", "displacement_m")}, {})) is None
    assert guide_friction_n(Recording({name: whole[name][:60] for name in whole.names}, {})) is None


def test_a_model_remembers_the_friction_of_the_simulated_bench() -> None:
    with open_rig("simulated") as rig:
        model = fit(characterize(rig))
    assert model.wire["guide_friction_n"] == pytest.approx(load_bench("paper").guide_friction_n.value, rel=0.02)
