"""Rigs that lie: by how much a wire can get too hot behind drawn lies of its device.

    python -m benchmarks.lying_rigs [--runs 1000] [--seed 1] [--quick]

Each run is a device without a pace around a wire of its own: a resistance within the window, a heat capacity, a latent
heat and a heat loss that are not those of the limits (never less loss than in still air). It is driven up and down at
random, as high as the rig allows, until the guard ends the run or 20 s have passed. What the guard gets to see is
drawn, too: readings of either channel scaled by 0.3 to 3, offset, late by up to six samples, repeated, exchanged with
the next ones, missing with and without an answer; a clock that runs at 0.2 to 10 times its pace, jitters and leaps; a
drive that the device says wrong.

Prints how the runs ended and the hottest of them with their seeds; exit code 1 if a wire was more than 10 K above its
limit in truth. `--one SEED` tells a single run.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections import Counter, deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from musclewire.controllers import Event, ProtectionLimits
from musclewire.errors import MusclewireError
from musclewire.rigs import Answer, DeviceFacts, GuardedRig, Metadata, Missing, ProtectionTripError, open_rig, rig_names
from musclewire.signals import Command, Drive, RawSample

RUNS, QUICK_RUNS = 1000, 100
RUN_S, PERIOD_S, MISSING_STEP_S = 20.0, 0.05, 0.03
ALLOWED_K = 10.0
RIGS: dict[str, Callable[[], GuardedRig]] = {
    "simulated": lambda: open_rig("simulated"),
    "finger": lambda: open_rig("finger"),
    # Comes with the part that grips.
    **({"gripper": lambda: open_rig("gripper")} if "gripper" in rig_names() else {}),
    "flexinol-0.15-lt": lambda: open_rig("simulated", wire="flexinol-0.15-lt"),
    "paper-200um": lambda: open_rig("simulated", wire="paper-200um"),
}


class Plant(NamedTuple):
    """A wire: cold resistance, what it loses when it contracts, and its heat balance beside that of the limits."""

    cold_ohm: float
    hot_ohm: float
    capacity_factor: float
    latent_k: float
    loss_factor: float


class Lies(NamedTuple):
    """What of the truth the guard gets to see: factors, chances per sample, samples, volts."""

    wire_scale: float
    shunt_scale: float
    wire_offset_v: float
    shunt_offset_v: float
    delay: int
    repeats: float
    swaps: float
    missing: float
    waits: float
    clock: float
    jitter_s: float
    leaps: float
    drive_scale: float


def drawn_lies(random: np.random.Generator) -> Lies:
    """Draw lies: a run tells about three of them, for many at once end at the first sample."""

    def told(value: float, truth: float) -> float:
        return value if random.random() < 0.2 else truth

    scales = np.exp(random.uniform(math.log(0.3), math.log(3.0), 2))
    if random.random() < 0.5:
        scales[1] = scales[0]  # the converter's reference: both channels alike, and no resistance shows it
    return Lies(
        wire_scale=told(scales[0], 1.0),
        shunt_scale=told(scales[1], 1.0),
        wire_offset_v=told(random.normal(0.0, 0.1), 0.0),
        shunt_offset_v=told(random.normal(0.0, 0.01), 0.0),
        delay=int(told(random.integers(0, 7), 0)),
        repeats=told(random.uniform(0.0, 0.9), 0.0),
        swaps=told(random.uniform(0.0, 0.5), 0.0),
        missing=told(random.uniform(0.0, 0.9), 0.0),
        waits=told(random.uniform(0.0, 0.9), 0.0),
        clock=told(float(np.exp(random.uniform(math.log(0.2), math.log(10.0)))), 1.0),
        jitter_s=told(random.uniform(0.0, 0.05), 0.0),
        leaps=told(random.uniform(0.0, 0.02), 0.0),
        drive_scale=told(random.uniform(0.3, 1.5), 1.0),
    )


class LyingWire:
    """A device around a plant, whose lies are drawn sample by sample."""

    def __init__(self, limits: ProtectionLimits, plant: Plant, lies: Lies, random: np.random.Generator) -> None:
        """Begin cold."""
        self.facts = DeviceFacts(
            PERIOD_S,
            paced=False,
            leg_length_m=0.07,
            drive_amplitude_v=3.0,
            limits=limits,
            wire_temperature_k=limits.ambient_temperature_k,
        )
        self.temperature_k = self.hottest_k = limits.ambient_temperature_k
        self.drive_voltage_v = 0.0
        self._plant, self._lies, self._random = plant, lies, random
        self._told_s, self._waited_s, self._due = 0.0, 0.0, True
        self._seen: deque[tuple[float, float]] = deque([(0.0, 0.0)] * (lies.delay + 2), maxlen=lies.delay + 2)
        self._said = (0.0, 0.0)

    def metadata(self) -> Metadata:
        """Return nothing."""
        return {}

    def hold(self, drive_v: float, dt_s: float) -> tuple[float, float]:
        """Hold a drive and return the true voltages at wire and shunt."""
        self.drive_voltage_v = drive_v
        limits, plant = self.facts.limits, self._plant
        for _ in range(5):
            contracted = min(max((self.temperature_k - 340.0) / 40.0, 0.0), 1.0)
            ohm = plant.cold_ohm + contracted * (plant.hot_ohm - plant.cold_ohm)
            current_a = drive_v / (ohm + limits.shunt_resistance_ohm)
            capacity = limits.heat_capacity_j_per_k * plant.capacity_factor
            if 0.0 < contracted < 1.0:
                capacity *= 1.0 + plant.latent_k / 40.0
            loss = limits.heat_loss_w_per_k * plant.loss_factor
            end_k = limits.ambient_temperature_k + current_a**2 * ohm / loss
            left = math.exp(-0.2 * dt_s * loss / capacity)
            self.temperature_k = end_k + (self.temperature_k - end_k) * left
            self.hottest_k = max(self.hottest_k, self.temperature_k)
        return current_a * ohm, current_a * limits.shunt_resistance_ohm

    def exchange(self, command: Command) -> Answer:
        """Hold a drive for a sample, or for a while in which the sample is said to be missing."""
        assert isinstance(command, Drive)
        lies, random = self._lies, self._random
        if random.random() < lies.waits:
            self.hold(command.voltage_v, MISSING_STEP_S)
            self._waited_s += MISSING_STEP_S
            return Missing(Event.SAMPLE_LATE, self._waited_s)
        self._seen.append(self.hold(command.voltage_v, PERIOD_S))
        self._waited_s = 0.0
        self._told_s += PERIOD_S * lies.clock + random.uniform(0.0, lies.jitter_s)
        if random.random() < lies.leaps:
            self._told_s += random.choice([-1.0, 0.2, 5.0])
        if random.random() >= lies.repeats:
            late = lies.delay + (1 if random.random() < lies.swaps else 0)
            self._said = self._seen[-1 - late]
        wire_v, shunt_v = self._said
        noise = 1e-5 * random.standard_normal(2)
        if random.random() < lies.missing:
            wire_v = math.nan
        return RawSample(
            self._told_s,
            lies.drive_scale * command.voltage_v,
            lies.wire_scale * wire_v + lies.wire_offset_v + noise[0],
            lies.shunt_scale * shunt_v + lies.shunt_offset_v + noise[1],
        )

    def sense(self) -> bool:
        """Go to the sense voltage."""
        self.drive_voltage_v = self.facts.limits.sense_voltage_v
        return True

    def off(self) -> bool:
        """Switch off."""
        self.drive_voltage_v = 0.0
        return True


class Outcome(NamedTuple):
    """A run: seed, rig, how far above its limit its wire was in truth at most [K], how it ended, plant and lies."""

    seed: int
    rig: str
    above_k: float
    ended: str
    plant: Plant
    lies: Lies


def all_limits() -> dict[str, ProtectionLimits]:
    """Return the limits of the rigs, by name."""
    found = {}
    for name, opened in RIGS.items():
        with opened() as rig:
            found[name] = rig.protection_limits
    return found


def often(value: float, worst: float, random: np.random.Generator) -> float:
    """Return a drawn value, or half of the time the one that is worst for the wire."""
    return worst if random.random() < 0.5 else value


def told(seed: int, limits_by_rig: dict[str, ProtectionLimits]) -> Outcome:
    """Draw a rig, a plant and lies from a seed, drive it until its end, and return what came of it."""
    random = np.random.default_rng(seed)
    name = str(random.choice(list(limits_by_rig)))
    limits = limits_by_rig[name]
    if random.random() < 0.5:  # of a user who allows more than the wire needs
        higher = {key: 1.7 * getattr(limits, key) for key in ("maximum_voltage_v", "maximum_current_a")}
        limits = limits._replace(**higher, maximum_power_w=3.0 * limits.maximum_power_w)
    limits = limits._replace(readings_noisy=float(random.random() < 0.5))
    low, high = limits.resistance_low_ohm, limits.resistance_high_ohm
    hot_ohm = low * often(math.exp(random.uniform(0.0, math.log(high / low))), 1.0, random)
    plant = Plant(
        cold_ohm=min(hot_ohm * random.uniform(1.0, 1.25), high),
        hot_ohm=hot_ohm,
        capacity_factor=often(random.uniform(1.0, 2.0), 1.0, random),
        latent_k=often(random.uniform(0.0, 80.0), 0.0, random),
        loss_factor=often(random.uniform(1.0, 2.0), 1.0, random),
    )
    device = LyingWire(limits, plant, drawn_lies(random), random)
    rig = GuardedRig(device)
    ended, elapsed_s = "20 s", 0.0
    try:
        while elapsed_s < RUN_S:
            drive_v = random.choice([0.3, random.uniform(0.3, 1.0), 1.0]) * limits.maximum_voltage_v
            for _ in range(random.integers(1, 60)):
                rig.exchange(max(drive_v, limits.sense_voltage_v))
                elapsed_s += PERIOD_S
    except ProtectionTripError as trip:
        ended = trip.event.name.lower()
    except MusclewireError as error:
        ended = type(error).__name__
    finally:
        rig.close()
    return Outcome(seed, name, device.hottest_k - limits.maximum_temperature_k, ended, plant, device._lies)


def main() -> int:
    """Run, print, and return the exit code."""
    parser = argparse.ArgumentParser(description="Rigs that lie: how hot a wire gets in truth.")
    parser.add_argument("--runs", type=int, default=None)
    parser.add_argument("--seed", type=int, default=1, help="of the first run; the others follow")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--one", type=int, default=None, help="seed of a single run")
    given = parser.parse_args()
    limits = all_limits()
    if given.one is not None:
        print(told(given.one, limits))
        return 0
    runs = given.runs or (QUICK_RUNS if given.quick else RUNS)
    outcomes = [told(seed, limits) for seed in range(given.seed, given.seed + runs)]
    print(f"{runs} runs of lying rigs, seeds {given.seed} to {given.seed + runs - 1}; how they ended:")
    for ended, count in Counter(outcome.ended for outcome in outcomes).most_common():
        print(f"  {count:5d}  {ended}")
    hottest = sorted(outcomes, key=lambda outcome: -outcome.above_k)
    print("hottest wires in truth, above their limit:")
    for outcome in hottest[:5]:
        print(f"  {outcome.above_k:+7.1f} K  seed {outcome.seed}, {outcome.rig}, ended by {outcome.ended}")
    return int(hottest[0].above_k > ALLOWED_K)


if __name__ == "__main__":
    sys.exit(main())
