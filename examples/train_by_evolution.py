"""Train a controller on a thousand simulated wires at once, and compare it with the plain PID it began as.

The policy is that PID with eight numbers more or less: its three gains, a correction of the estimate for each direction
of motion, and a push at each step of the target with its own time constant. An evolution strategy of a few lines finds
them from the reward alone. The reward is what docs/how-to/train_a_controller.md states: minus the error in percent
strain, judged by the displacement sensor; the policy sees voltages, target and the estimator's strain. With --quick
smaller numbers of everything.
"""

import argparse

import numpy as np

import musclewire as mw
from musclewire import WireVectorEnv

TARGET, ESTIMATE = 4, 5  # places in an observation
DT_S, FILTER_S = 0.05, 0.2
GAINS = np.array([0.06, 0.04, 0.00075])  # the plain PID's, as the package has them
VOLTS_PER_PERCENT = 20.0
NAMES = ("plain PID", "trained gains", "trained")


class Policies:
    """One policy a wire, as arrays: numbers, (n_wires, 8), all 0 for the plain PID."""

    def __init__(self, numbers: np.ndarray, observed: np.ndarray, drive_range_v: tuple[float, float]) -> None:
        self.kp, self.ki, self.kd = (GAINS * np.exp(numbers[:, :3])).T
        self.correction = 0.05 * numbers[:, 3:5]  # percent strain, on the way up and on the way down
        self.push_v = 1.0 * numbers[:, 5:7]  # volts per percent strain of a step, up and down
        self.push_s = 0.5 * np.exp(numbers[:, 7])
        self.low_v, self.high_v = drive_range_v
        self.drive_v = np.full(len(numbers), self.low_v)
        self.pushed = np.zeros(len(numbers))
        self.falling = np.zeros(len(numbers), dtype=int)
        self.target, self.estimate = 100.0 * observed[:, TARGET], 100.0 * observed[:, ESTIMATE]
        self.error, self.rate = self.target - self.estimate, np.zeros(len(numbers))

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Return the actions for a sample, (n_wires, 1)."""
        target, estimate = 100.0 * observed[:, TARGET], 100.0 * observed[:, ESTIMATE]
        step = target - self.target
        self.falling = np.where(step == 0.0, self.falling, step < 0.0).astype(int)
        rows = np.arange(len(step))
        error = target - estimate - self.correction[rows, self.falling]
        rate = self.rate + DT_S / (FILTER_S + DT_S) * ((estimate - self.estimate) / DT_S - self.rate)
        change = self.kp * (error - self.error) + self.ki * DT_S * error - self.kd * (rate - self.rate)
        self.drive_v = np.clip(self.drive_v + VOLTS_PER_PERCENT * change, self.low_v, self.high_v)
        self.pushed = self.pushed * np.exp(-DT_S / self.push_s) + self.push_v[rows, self.falling] * step
        self.target, self.estimate, self.error, self.rate = target, estimate, error, rate
        drive_v = np.clip(self.drive_v + self.pushed, self.low_v, self.high_v)
        return (2.0 * (drive_v - self.low_v) / (self.high_v - self.low_v) - 1.0)[:, None]


def mean_rewards(env: WireVectorEnv, numbers: np.ndarray, seed: int, drive_range_v: tuple[float, float]) -> np.ndarray:
    """Return the mean reward of a sample for each policy, over one episode on its own part of the wires."""
    each = env.num_envs // len(numbers)
    observed, _ = env.reset(seed=seed)
    policies = Policies(np.repeat(numbers, each, axis=0), observed, drive_range_v)
    total, samples, done = np.zeros(env.num_envs), 0, False
    while not done:
        observed, reward, terminated, truncated, _ = env.step(policies.act(observed))
        total, samples, done = total + reward, samples + 1, bool((terminated | truncated).all())
    return (total / samples).reshape(len(numbers), each).mean(axis=1)


def evolved(
    env: WireVectorEnv, seed: int, generations: int, free: int, drive_range_v: tuple[float, float]
) -> np.ndarray:
    """Return the numbers that an evolution strategy finds, (8,), the first ``free`` of them not 0.

    The better half of 32 candidates is recombined with weights; the candidates come in pairs with opposite steps.
    """
    random = np.random.default_rng(seed)
    count, spread, best = 32, 0.5, np.zeros(8)
    weights = np.log(count / 2 + 0.5) - np.log(np.arange(1, count // 2 + 1))
    weights /= weights.sum()
    for generation in range(generations):
        steps = random.standard_normal((count // 2, 8))
        steps[:, free:] = 0.0
        steps = spread * 0.95**generation * np.concatenate([steps, -steps])
        rewards = mean_rewards(env, best + steps, 1000 * seed + generation, drive_range_v)
        best = best + weights @ steps[np.argsort(-rewards)[: count // 2]]
    return best


def compared(seeds: int, generations: int, wires: int, episode: dict[str, object]) -> np.ndarray:
    """Return mean rewards on unseen episodes, (n_seeds, 3): the plain PID, with trained gains, all eight trained."""
    with mw.open_rig("simulated") as rig:
        model = mw.fit(mw.characterize(rig))
        drive_range_v = (rig.sense_voltage_v, rig.maximum_voltage_v)
    env = WireVectorEnv(wires, model=model, episode=episode)
    rows = []
    for seed in range(1, seeds + 1):
        found = [np.zeros(8), *(evolved(env, seed, generations, free, drive_range_v) for free in (3, 8))]
        # The same wires, targets and noise for all three, which the training has not seen.
        rows.append([mean_rewards(env, one[None], 10**6 + seed, drive_range_v)[0] for one in found])
        print(
            f"seed {seed}: " + ", ".join(f"{name} {reward:.4f}" for name, reward in zip(NAMES, rows[-1], strict=True))
        )
        print("  trained gains over the plain PID's: {:.2f}, {:.2f}, {:.2f}".format(*np.exp(found[1][:3])))
    return np.array(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer wires, generations, seeds and levels")
    quick = parser.parse_args().quick
    episode = {"targets": "random", "hold_s": 4.0, "approach_s": 6.0, "increments": 2 if quick else 5}
    rewards = compared(*((3, 6, 256) if quick else (5, 20, 512)), episode)
    print(f"median of {len(rewards)} seeds, and the range:")
    for name, column in zip(NAMES, rewards.T, strict=True):
        print(f"{name:13} mean reward {np.median(column):.4f} ({column.min():.4f} to {column.max():.4f})")
    less = 100.0 * (1.0 - np.median(rewards[:, 2] / rewards[:, 0]))
    print(f"the trained policy's mean error is {less:.0f} % below the plain PID's")


if __name__ == "__main__":
    main()
