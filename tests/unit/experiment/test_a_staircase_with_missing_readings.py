"""A closed loop goes on though one reading of a hundred is missing, and the estimated temperature hardly notices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.contract.altered_device import AlteredDevice

import musclewire as mw
from musclewire.controllers import Protection
from musclewire.rigs import Answer, GuardedRig
from musclewire.signals import RawSample


@pytest.fixture(scope="module")
def model() -> mw.SensingModel:
    with mw.open_rig("simulated") as rig:
        return mw.fit(mw.characterize(rig))


class Loosened:
    """Loses readings at random; a protection of its own judges them all."""

    def __init__(self, share: float, seed: int, protection: Protection) -> None:
        self._share, self._random, self._protection = share, np.random.default_rng(seed), protection
        self.rig: GuardedRig | None = None
        self.added_k = 0.0

    def __call__(self, answer: Answer) -> Answer:
        assert isinstance(answer, RawSample)
        if self.rig is not None:  # the guard has judged the sample before this one
            self.added_k = max(self.added_k, abs(self.rig.protection.temperature_k - self._protection.temperature_k))
        self._protection.command(answer.drive_voltage_v)
        self._protection.sample(answer.drive_voltage_v, answer.wire_voltage_v, answer.shunt_voltage_v, 0.05)
        if self._random.random() < self._share:
            return answer._replace(wire_voltage_v=math.nan, shunt_voltage_v=math.nan)
        return answer


@pytest.mark.parametrize("seeds", [pytest.param(2, marks=pytest.mark.slow), pytest.param(100, marks=pytest.mark.full)])
def test_one_percent_of_readings_missing_ends_no_staircase_and_adds_half_a_kelvin_at_most(
    model: mw.SensingModel, seeds: int
) -> None:
    added_k = []
    for seed in range(seeds):
        inner = mw.open_rig("simulated", seed=seed)
        loosened = Loosened(0.01, seed, Protection(inner.protection_limits))
        rig = GuardedRig(AlteredDevice(inner.device, loosened))
        loosened.rig = rig
        with rig:
            mw.control(rig, model, mw.staircase())
        added_k.append(loosened.added_k)
    print(f"added to the estimate: median {np.median(added_k):.3f} K, at most {max(added_k):.3f} K")
    assert max(added_k) <= 0.5
