"""The paper's bench as a rig that needs no hardware: wire, spring, circuit, acquisition, instruments."""

from __future__ import annotations

import math
import time
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from musclewire.errors import CallerError, NumericsError, RigError
from musclewire.parameters.schema import Alloy, Bench, Wire
from musclewire.rigs.protocol import Metadata
from musclewire.signals.samples import RawSample
from musclewire.simulate.kernel import advance
from musclewire.simulate.state import WireState
from musclewire.simulate.wire import constants_from, resting_state, with_pretension

__all__ = ["SimulatedRig"]


class SimulatedRig:
    """A simulated wire on a simulated bench, repeatable to the bit for one seed.

    It hands out what the real instruments would: voltages in steps of the converter with its noise, a
    displacement and a force with theirs. Temperature, phases and parameters stay inside; ``wire_state`` shows
    them to whoever judges a simulation, never to an estimator.
    """

    def __init__(
        self,
        alloy: Alloy,
        wire: Wire,
        bench: Bench,
        *,
        seed: int = 1,
        new_wire: bool = False,
        real_time: bool = False,
    ) -> None:
        """Cool the wire under its pretension and wait at 0 V.

        ``new_wire`` starts before the first cycles (shakedown); ``real_time`` paces samples by the clock.
        Raises CallerError for numbers that cannot belong to a bench.
        """
        self._wire = wire
        self._bench = bench.values()
        self._wire_values = wire.values()
        self._seed = seed
        self._new_wire = new_wire
        self._random = np.random.default_rng(seed)
        self._constants = constants_from(alloy, wire, bench, new_wire=new_wire)
        self._state = resting_state(self._constants)
        self._drive_voltage_v = 0.0
        self._off_for_good = False
        self._check_pretension(self._bench["pretension_n"])
        if self.sense_voltage_v >= self.maximum_voltage_v:
            raise CallerError(
                f"sense_voltage_v {self.sense_voltage_v} V must be below maximum_voltage_v {self.maximum_voltage_v} V"
            )
        self._real_time = real_time
        self._next_due_s: float | None = None
        self._steps = self._steps_of_a_sample()
        self._voltage_step_v = 2.0 * self._bench["acquisition_range_v"] / 2.0 ** self._bench["acquisition_bits"]

    def _steps_of_a_sample(self) -> int:
        ratio = self._bench["sample_period_s"] / self._bench["time_step_s"]
        if ratio < 1.0 or abs(ratio - round(ratio)) > 1e-6:
            raise CallerError(
                f"time_step_s {self._bench['time_step_s']} must divide sample_period_s "
                f"{self._bench['sample_period_s']} without a rest"
            )
        return round(ratio)

    @property
    def sample_period_s(self) -> float:
        """Time between samples."""
        return self._bench["sample_period_s"]

    @property
    def paced(self) -> bool:
        """Whether samples wait for the clock."""
        return self._real_time

    @property
    def sense_voltage_v(self) -> float:
        """Lowest drive voltage while sensing."""
        return self._bench["sense_voltage_v"]

    @property
    def maximum_voltage_v(self) -> float:
        """Highest drive voltage allowed."""
        return self._wire_values["maximum_voltage_v"]

    @property
    def drive_amplitude_v(self) -> float:
        """Amplitude of the slow sine for this wire."""
        return self._wire_values["drive_amplitude_v"]

    @property
    def shunt_resistance_ohm(self) -> float:
        """R of Eq. 1."""
        return self._bench["shunt_resistance_ohm"]

    @property
    def leg_length_m(self) -> float:
        """Length of one leg of the V."""
        return self._bench["wire_length_m"] / self._bench["legs"]

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage that is out now."""
        return self._drive_voltage_v

    @property
    def wire_state(self) -> WireState:
        """The simulated truth: temperature, phases, energy. For judging a simulation, not for estimating."""
        return self._state

    def __repr__(self) -> str:
        """Say which wire, at what pretension, and what is out."""
        return (
            f"SimulatedRig(wire {self._wire.name}, pretension {self._constants.pretension_n:g} N, "
            f"drive {self._drive_voltage_v:.3f} V, at {self._state.time_s:.2f} s)"
        )

    def metadata(self) -> Metadata:
        """Return what a recording should say about this rig."""
        return {
            "rig": "simulated",
            "wire": self._wire.name,
            "wire_diameter_m": self._wire.diameter_m.value,
            "wire_length_m": self._bench["wire_length_m"],
            "leg_length_m": self.leg_length_m,
            "shunt_resistance_ohm": self.shunt_resistance_ohm,
            "maximum_force_n": self._wire.maximum_force_n.value,
            "pretension_n": self._constants.pretension_n,
            "spring_stiffness_n_per_m": self._bench["spring_stiffness_n_per_m"],
            "sample_period_s": self.sample_period_s,
            "time_step_s": self._bench["time_step_s"],
            "grains": int(self._bench["grains"]),
            "new_wire": self._new_wire,
            "seed": self._seed,
        }

    def set_pretension(self, pretension_n: float) -> None:
        """Let the wire cool, then move the stage; the instruments are zeroed there.

        The clock goes on and the wire keeps what it has been through in cycles.
        """
        self._check_pretension(pretension_n)
        self._drive_voltage_v = 0.0
        constants = with_pretension(self._constants, pretension_n)
        # What a new wire has gained in length by now belongs to the new zero.
        fresh = math.exp(-self._state.cycles / constants.shakedown_cycles)
        gained = constants.shakedown_strain * (1.0 - fresh)
        self._constants = constants._replace(cold_strain=constants.cold_strain + gained)
        rested = resting_state(self._constants)
        self._state = rested._replace(time_s=self._state.time_s, cycles=self._state.cycles)

    def _check_pretension(self, pretension_n: float) -> None:
        allowed = self._wire_values["maximum_force_n"]
        if not 0.0 <= pretension_n <= allowed:
            raise CallerError(f"pretension {pretension_n} N is outside 0 to {allowed} N, what {self._wire.name} allows")

    def exchange(self, drive_voltage_v: float) -> RawSample:
        """Hold a drive voltage for one sample period and return the averaged readings at its end."""
        if self._off_for_good:
            raise RigError("this rig is closed or has failed and stays off: open it again")
        if not (math.isfinite(drive_voltage_v) and 0.0 <= drive_voltage_v <= self.maximum_voltage_v + 1e-9):
            self.close()
            raise RigError(
                f"drive voltage {drive_voltage_v} V is outside 0 to {self.maximum_voltage_v} V; the drive is off"
            )
        resolution = self._bench["amplifier_resolution_v"]
        self._drive_voltage_v = resolution * round(drive_voltage_v / resolution)
        self._state, means = advance(
            self._state, self._constants, self._drive_voltage_v, self._bench["time_step_s"], self._steps
        )
        if not math.isfinite(self._state.temperature_k):
            self.close()
            raise NumericsError(
                f"the simulated wire left its numbers at {self._state.time_s:.3f} s: make time_step_s smaller"
            )
        self._wait_until_due()
        wire_voltage, shunt_voltage = self._converted(means.wire_voltage_v, means.shunt_voltage_v)
        displacement_noise, force_noise = self._random.standard_normal(2)
        return RawSample(
            time_s=self._state.time_s,
            drive_voltage_v=self._drive_voltage_v,
            wire_voltage_v=wire_voltage,
            shunt_voltage_v=shunt_voltage,
            displacement_m=means.displacement_m + self._bench["displacement_noise_m"] * displacement_noise,
            force_n=means.force_n + self._bench["force_noise_n"] * force_noise,
        )

    def _converted(self, *voltages_v: float) -> tuple[float, ...]:
        """Return what a converter with noise, steps and a range makes of voltages, averaged over its readings."""
        readings = int(self._bench["acquisition_readings"])
        noise: NDArray[np.float64] = self._random.standard_normal((len(voltages_v), readings))
        noisy = np.asarray(voltages_v)[:, None] + self._bench["acquisition_noise_v"] * noise
        stepped = np.round(noisy / self._voltage_step_v) * self._voltage_step_v
        limit = self._bench["acquisition_range_v"]
        return tuple(float(value) for value in np.clip(stepped, -limit, limit).mean(axis=1))

    def _wait_until_due(self) -> None:
        if not self._real_time:
            return
        now = time.monotonic()
        due = now if self._next_due_s is None else self._next_due_s
        if due > now:
            time.sleep(due - now)
        # Deadlines are absolute, so that a late sample does not shift all that follow.
        self._next_due_s = max(due, now - self.sample_period_s) + self.sample_period_s

    def make_safe(self) -> None:
        """Go to the sense voltage at once; a rig that is off for good stays off."""
        self._drive_voltage_v = 0.0 if self._off_for_good else self.sense_voltage_v

    def close(self) -> None:
        """Switch the drive off for good."""
        self._off_for_good = True
        self._drive_voltage_v = 0.0

    def __enter__(self) -> Self:
        """Return the rig itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Switch the drive off."""
        self.close()
