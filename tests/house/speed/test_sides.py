"""Both sides of a comparison do the work that its row says, and the closed loop of one's own reaches its target."""

from __future__ import annotations

import pytest
from benchmarks.speed.batch_cases import batch_cases
from benchmarks.speed.loop_cases import PlainLoop, loop_cases, plain_environment, plain_steps


def test_the_plain_loop_reaches_its_targets_and_the_plain_environment_moves() -> None:
    loop = PlainLoop()
    for target in (0.3, 0.7):
        reached = [loop.sample(target) for _ in range(400)]
        assert reached[-1] == pytest.approx(target, abs=0.05)
    environment = plain_environment()
    plain_steps([1.0], environment)
    assert environment.wire.state[1] < 0.5


@pytest.mark.parametrize("case", [*batch_cases(), *loop_cases()], ids=lambda case: case.name)
def test_both_sides_run(case: object) -> None:
    ours, theirs = case.sides(True)  # type: ignore[attr-defined]
    if case.name in {one.name for one in batch_cases()}:  # type: ignore[attr-defined]
        assert ours.units == theirs.units
    assert ours.time_us() > 0.0
    assert theirs.time_us() > 0.0
