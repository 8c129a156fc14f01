"""A loop that runs says that it misses its target once that has lasted, and not while its speed limits explain it."""

from __future__ import annotations

from musclewire.judge import MissWatch

PERIOD_S = 0.05


def said(estimates: list[float], target: float = 0.02, announced: float = 0.0, approach_s: float = 0.0) -> list[str]:
    """Return what a watch says after each sample, of a model that senses 3 % of strain."""
    watch = MissWatch("strain", 0.03, approach_s)
    return [
        watch.after(
            {
                "time_s": PERIOD_S * (index + 1),
                "target_strain": target,
                "estimated_strain": estimate,
                "estimate_std": 1e-4,
                "valid": 1.0,
                "announced_miss": announced,
                "displacement_m": None,
            }
        )
        for index, estimate in enumerate(estimates)
    ]


def test_a_miss_is_said_once_it_has_lasted_for_a_second_with_when_it_began_and_until_it_ends() -> None:
    seen = said([0.02] * 20 + [0.018] * 40 + [0.02] * 10)
    assert not any(seen[:40])
    assert set(seen[42:60]) == {"target missed from 1.1 s on"}
    assert not any(seen[60:])


def test_what_is_announced_within_the_interval_or_part_of_the_approach_is_not_said() -> None:
    assert not any(said([0.018] * 100, announced=-0.003))
    assert not any(said([0.0193] * 100))
    assert not any(said([0.018] * 100, approach_s=10.0))
    assert any(said([0.018] * 100, announced=0.003))


def test_steps_that_each_take_less_than_a_second_say_nothing_in_between() -> None:
    assert not any(said(([0.018] * 10 + [0.02] * 10) * 10))
