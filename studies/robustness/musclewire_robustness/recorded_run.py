"""One recorded run: what an estimator sees, and what it is judged by."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from musclewire import FloatArray
from musclewire.signals import write_whole


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """One recorded run; times count from the reference's start, before which lies the start-up loop.

    Parameters
    ----------
    seed
        Seed of the wire.
    condition
        Name of the condition.
    reference
        Name of the reference.
    time_s
        Time of each sample [s], (n_samples,), from the reference's start; negative in the start-up loop.
    clock_s
        The same on the rig's clock, as the estimator gets it.
    drive_voltage_v, wire_voltage_v, shunt_voltage_v
        What an estimator sees [V], (n_samples,).
    strain
        Strain by the displacement sensor with the zero of the characterization, (n_samples,).
    zero_shift
        By how much a new zero would differ at each sample, (n_samples,).
    force_n
        Force by the load cell [N], (n_samples,).
    temperature_k
        True temperature, mean over the length [K], (n_samples,).
    target
        Target, as strain, (n_samples,).
    change_level
        How much of the change is there, 0 to 1, (n_samples,).
    ended
        Why the run ended before its end; "" if it did not.
    home
        What became of the home move before it; "" without one.
    facts
        Numbers of the rig by name.
    """

    seed: int
    condition: str
    reference: str
    time_s: FloatArray
    clock_s: FloatArray
    drive_voltage_v: FloatArray
    wire_voltage_v: FloatArray
    shunt_voltage_v: FloatArray
    strain: FloatArray
    zero_shift: FloatArray
    force_n: FloatArray
    temperature_k: FloatArray
    target: FloatArray
    change_level: FloatArray
    ended: str = ""
    home: str = ""
    facts: dict[str, float] = field(default_factory=dict)

    @property
    def counts(self) -> bool:
        """Whether the run is judged: it has samples, and a home move before it was not refused with a cause."""
        return self.time_s.size > 0 and not self.home.startswith("refused")

    def save(self, path: Path) -> None:
        """Write all arrays, whole or not at all."""
        arrays: dict[str, Any] = {key: value for key, value in self.__dict__.items() if isinstance(value, np.ndarray)}
        plain = np.array([self.condition, self.reference, self.ended, self.home])

        def write(part: Path) -> None:
            with part.open("wb") as file:
                np.savez_compressed(
                    file,
                    seed=self.seed,
                    plain=plain,
                    facts_names=np.array(list(self.facts)),
                    facts=np.array(list(self.facts.values())),
                    **arrays,
                )

        write_whole(path, write)

    @staticmethod
    def load(path: Path) -> RecordedRun:
        """Read a run."""
        with np.load(path) as data:
            arrays = {name: data[name] for name in data.files}
        seed = int(arrays.pop("seed"))
        condition, reference, ended, home = arrays.pop("plain").tolist()
        facts = dict(zip(arrays.pop("facts_names").tolist(), arrays.pop("facts").tolist(), strict=True))
        return RecordedRun(seed, condition, reference, **arrays, ended=ended, home=home, facts=facts)
