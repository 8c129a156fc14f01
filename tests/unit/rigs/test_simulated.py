"""What is special to the simulated rig; what every rig must do is in tests/contract."""

from __future__ import annotations

import pytest

from musclewire.rigs import GuardedRig, HasStage, HasTrueState, ability, open_rig
from musclewire.signals import RawSample

DRIVE_V = [0.3, 1.0, 3.0, 3.2, 2.0, 0.3]


def samples(rig: GuardedRig, drive_v: list[float] = DRIVE_V) -> list[RawSample]:
    with rig:
        return [rig.exchange(voltage) for voltage in drive_v]


def test_another_seed_gives_other_noise_on_the_same_wire() -> None:
    first, second = (open_rig("simulated", seed=seed) for seed in (5, 6))
    ours, others = samples(first), samples(second)
    for field in ("wire_voltage_v", "shunt_voltage_v", "displacement_m", "force_n"):
        assert [getattr(s, field) for s in ours] != [getattr(s, field) for s in others], field
    assert (
        ability(first, HasTrueState).wire_state.temperature_k == ability(second, HasTrueState).wire_state.temperature_k
    )


def test_the_drive_goes_out_in_steps_of_the_amplifier() -> None:
    rig = open_rig("simulated", amplifier_resolution_v=0.1)
    assert samples(rig, [1.23])[0].drive_voltage_v == pytest.approx(1.2)


def test_the_stage_sets_the_pretension_and_zeroes_the_instruments() -> None:
    rig = open_rig("simulated", force_noise_n=0.0, displacement_noise_m=0.0)
    assert ability(rig, HasStage) is not None
    with rig:
        for _ in range(40):
            warm = rig.exchange(3.2)
        ability(rig, HasStage).set_pretension(2.5)
        sample = rig.exchange(0.0)
    assert warm.displacement_m > 1e-4
    assert sample.force_n == pytest.approx(2.5, abs=1e-6)
    assert sample.displacement_m == pytest.approx(0.0, abs=1e-9)
    assert sample.time_s == pytest.approx(warm.time_s + rig.sample_period_s)
    assert rig.metadata()["pretension_n"] == 2.5
