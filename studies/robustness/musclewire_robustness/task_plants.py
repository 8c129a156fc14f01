"""Plants of the tasks: rigs that ship, wires of other families, drawn wires; each as its user knows it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from musclewire import (
    CallerError,
    DeviceConfiguration,
    GuardedRig,
    RigConfiguration,
    SensingModel,
    characterize,
    drive_voltage_of,
    fit,
    load_model,
    open_rig,
)
from musclewire.extras.studies import Conditions
from musclewire.rigs import SimulatedDevice
from musclewire.signals import Command, Drive
from musclewire_robustness.characterizing import slow_loop
from musclewire_robustness.plant import open_plant
from musclewire_robustness.population import drawn_wire
from musclewire_robustness.tasks import Change

# The run of a wire that tasks have, for its noise; other rigs have this much added to the seed of their slow loop.
RUN_NUMBER, RUN_SEED = 60, 10_000
RAMP_S, DRAUGHT_S, STRONGEST = 1.0, 3.0, 3.0
STREAM = 20
EXAMPLES = Path.cwd() / "examples" / "plants"


@dataclass(frozen=True)
class TaskPlant:
    """A kind of plant.

    Parameters
    ----------
    rig
        What ``open_rig`` takes; None for the drawn wires.
    quantity
        What is controlled.
    has_load
        Whether its load can change while it runs.
    """

    rig: str | Path | DeviceConfiguration | None
    quantity: str = "strain"
    has_load: bool = False

    def refuse_unless_here(self) -> None:
        """Raise CallerError for an example of the checkout that is run elsewhere."""
        if isinstance(self.rig, Path) and not self.rig.exists():
            raise CallerError(f"{self.rig.stem} is an example of the checkout, and {self.rig} is none: run this there")

    def opened(self, seed: int, *, of_task: bool) -> GuardedRig:
        """Return the rig of a seed as it was characterized, or that on which it does a task."""
        if self.rig is None:
            return open_plant(drawn_wire(seed), run=RUN_NUMBER if of_task else 1).rig
        return open_rig(self.rig, seed=seed + RUN_SEED if of_task else seed)

    def model_in(self, file: Path, seed: int) -> SensingModel:
        """Return the model of a seed's slow loop, which is recorded now or was before; a file keeps it."""
        if not file.exists():
            file.parent.mkdir(parents=True, exist_ok=True)
            self._fitted(seed).save(file)
        return load_model(file)

    def _fitted(self, seed: int) -> SensingModel:
        """Return the model of a slow loop that is recorded now."""
        if self.rig is None:
            return fit(slow_loop(drawn_wire(seed)), quantity=self.quantity)
        with self.opened(seed, of_task=False) as rig:
            return fit(characterize(rig, minor_loop=False), quantity=self.quantity)


FLEXINOL = RigConfiguration(wire="flexinol-0.15-lt", settings={"pretension_n": 2.5})
PLANTS: Mapping[str, TaskPlant] = {
    "simulated": TaskPlant("simulated"),
    "finger": TaskPlant("finger", "displacement"),
    "gripper": TaskPlant("gripper", "displacement"),
    "flexinol-0.15-lt": TaskPlant(FLEXINOL),
    "wires": TaskPlant(None, has_load=True),
    "Liang-Rogers": TaskPlant(EXAMPLES / "liang_rogers.toml", has_load=True),
    "Duhem": TaskPlant(EXAMPLES / "duhem.toml", has_load=True),
}


class AirAround(NamedTuple):
    """The air at one time: how much warmer it is [K], and the ratio of convection to that in still air."""

    warmer_k: float
    convection_ratio: float


class ChangedAir:
    """Air that changes within a second at a time on the rig's clock, and the draughts that come with it.

    Parameters
    ----------
    change
        What changes.
    at_s
        When [s].
    seed
        Seed of the draughts.
    """

    loss = 1.0  # the wire hangs bare, and its air is still at first

    def __init__(self, change: Change, at_s: float, seed: int) -> None:
        """Begin in still air."""
        self._change, self._at_s = change, at_s
        self._random, self._draught = np.random.default_rng([STREAM, seed]), 0.0

    def level(self, time_s: float) -> float:
        """Return how much of the change is there, from 0 to 1."""
        return min(max((time_s - self._at_s) / RAMP_S, 0.0), 1.0)

    def after(self, time_s: float, dt_s: float) -> AirAround:
        """Return the air at a time, a sample after the last call: draughts are an Ornstein-Uhlenbeck process."""
        kept = math.exp(-dt_s / DRAUGHT_S)
        self._draught = kept * self._draught + math.sqrt(1.0 - kept * kept) * float(self._random.standard_normal())
        strength = min(max(self._draught, -STRONGEST), STRONGEST)
        level, change = self.level(time_s), self._change
        return AirAround(level * change.warmer_k, change.convection**level * (1.0 + level * change.draught * strength))


def changed(rig: GuardedRig, change: Change, at_s: float, seed: int) -> None:
    """Let a rig's surroundings, load and supply change at a time on its clock [s]."""
    device: Any = rig.device
    air = ChangedAir(change, at_s, seed)
    if isinstance(device, SimulatedDevice):
        device.air = air if change.of_the_air else None  # type: ignore[assignment]  # drawn sample by sample, too
    else:
        device.conditions = conditions_of(air, change, rig)
    if change.of_the_supply:
        device.exchange = weaker(device.exchange, change, rig.maximum_voltage_v)


def conditions_of(air: ChangedAir, change: Change, rig: GuardedRig) -> Callable[[float], Conditions]:
    """Return what is around a wire, and its load, as a function of time."""
    ambient_k, period_s = rig.protection_limits.ambient_temperature_k, rig.sample_period_s
    load_n = change.load * float(rig.metadata().get("pretension_n") or 0.0)

    def conditions(time_s: float) -> Conditions:
        around = air.after(time_s, period_s)
        return Conditions(
            ambient_k=ambient_k + around.warmer_k,
            convection_factor=around.convection_ratio,
            load_force_n=air.level(time_s) * load_n,
        )

    return conditions


def weaker(exchange: Callable[[Command], Any], change: Change, maximum_v: float) -> Callable[[Command], Any]:
    """Return the exchange of a device whose supply gives less than is asked for."""

    def exchanged(command: Command) -> Any:
        return exchange(Drive(min(change.drive * drive_voltage_of(command), change.most * maximum_v)))

    return exchanged
