"""The example's training, in small: for every seed the trained policy earns more than the PID that it began as."""

from __future__ import annotations

import importlib.util
from types import ModuleType

import numpy as np
import pytest
from tests.places import EXAMPLES

EXAMPLE = EXAMPLES / "train_by_evolution.py"


def example() -> ModuleType:
    """Return the example as a module; the folder of the examples is no package."""
    spec = importlib.util.spec_from_file_location(EXAMPLE.stem, EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_a_short_training_beats_the_plain_pid_for_every_seed() -> None:
    episode = {"targets": "random", "hold_s": 4.0, "approach_s": 6.0, "increments": 1}
    rewards = example().compared(seeds=3, generations=4, wires=128, episode=episode)
    errors = -rewards / -rewards[:, :1]
    print("errors relative to the plain PID's, gains trained and all trained:", np.median(errors, axis=0)[1:])
    assert (errors[:, 1:] < 0.8).all(), errors
    spread = np.ptp(errors[:, 2])
    assert spread < 0.3, "the seeds agree"


def test_with_all_numbers_zero_the_policy_is_the_plain_pid() -> None:
    from musclewire.controllers import ControllerSetup, DriveLimits, pid_controller
    from musclewire.signals import Drive, QuantityEstimate

    random = np.random.default_rng(1)
    targets, estimates = np.repeat(random.uniform(0.015, 0.03, 10), 20), random.uniform(0.01, 0.03, 200)
    observed = np.zeros((200, 6))
    observed[:, 4], observed[:, 5] = targets, estimates
    policy = example().Policies(np.zeros((1, 8)), observed[:1], (0.3, 3.6))
    pid = pid_controller(ControllerSetup(DriveLimits(0.3, 3.6)))
    state = pid.step(pid.start(0.3), targets[0], QuantityEstimate(estimates[0], 0.0, True), 0.05).state
    state = (state[0], 0.3, *state[2:])  # the second is the drive voltage
    for row in range(1, 200):
        action = policy.act(observed[row : row + 1])[0, 0]
        step = pid.step(state, targets[row], QuantityEstimate(estimates[row], 0.0, True), 0.05)
        state = step.state
        assert isinstance(step.command, Drive)
        assert 0.3 + 0.5 * (action + 1.0) * 3.3 == pytest.approx(step.command.voltage_v, rel=1e-9)
