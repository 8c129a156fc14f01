"""A wire that pulls harder than it may is warned of, whatever it pulls and however it was driven."""

from __future__ import annotations

import numpy as np

from musclewire.experiment import characterize
from musclewire.experiment._run_warnings import force_warnings
from musclewire.rigs import open_rig
from musclewire.signals import MetadataValue, Recording


def pulled(force_n: np.ndarray, **metadata: MetadataValue) -> Recording:
    time = 0.5 * np.arange(force_n.size)
    return Recording({"time_s": time, "drive_voltage_v": 0.1 * time, "force_n": force_n}, metadata)


def test_a_force_above_the_limit_is_named_with_limit_place_and_duration() -> None:
    force = np.r_[np.linspace(1.0, 6.0, 51), np.linspace(6.0, 1.0, 51)]
    (warning,) = force_warnings(pulled(force, maximum_force_n=4.95, wire="mine"))
    assert warning.startswith(
        "the wire pulls with up to 6.00 N at 25.0 s, drive 2.50 V, 1.05 N above the 4.95 N allowed"
    )
    assert "maximum_force_n of wire mine" in warning
    assert "above it for 11.0 s in total" in warning


def test_at_the_limit_noise_is_no_warning_and_without_a_limit_there_is_none() -> None:
    noise = 2e-3 * np.random.default_rng(0).normal(size=4000)
    assert force_warnings(pulled(4.6 + noise, maximum_force_n=4.601)) == ()
    assert force_warnings(pulled(4.63 + noise, maximum_force_n=4.601)) != ()
    assert force_warnings(pulled(9.0 + noise)) == ()
    assert force_warnings(Recording({"time_s": np.arange(3.0)}, {"maximum_force_n": 1.0})) == ()


def test_the_papers_bench_and_the_finger_stay_below_their_limit() -> None:
    for name in ("simulated", "finger"):
        with open_rig(name) as rig:
            assert force_warnings(characterize(rig, cycles=1, period_s=30.0)) == ()
