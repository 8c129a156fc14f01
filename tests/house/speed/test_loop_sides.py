"""The closed loop of one's own, with which ours is compared, reaches its target; both sides count the same unit."""

from __future__ import annotations

import pytest
from benchmarks.speed.loop_cases import PlainLoop, loop_cases, plain_environment, plain_steps


def test_the_plain_loop_reaches_its_targets() -> None:
    loop = PlainLoop()
    for target in (0.3, 0.7):
        reached = [loop.sample(target) for _ in range(400)]
        assert reached[-1] == pytest.approx(target, abs=0.05)


def test_the_plain_environment_moves() -> None:
    environment = plain_environment()
    plain_steps([1.0], environment)
    assert environment.wire.state[1] < 0.5


@pytest.mark.parametrize("case", list(loop_cases()), ids=lambda case: case.name)
def test_both_sides_run(case: object) -> None:
    ours, theirs = case.sides(True)  # type: ignore[attr-defined]
    assert ours.time_us() > 0.0
    assert theirs.time_us() > 0.0
