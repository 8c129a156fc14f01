"""The wire on the bench of an emulated board: output codes in, converter codes out, one tick at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from pydantic import TypeAdapter

from musclewire.errors import CallerError
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.rigs import SimulatedLoad, SimulatedSpool, wires_of, with_settings
from musclewire.wire import CHOSEN, spring_load

if TYPE_CHECKING:
    from musclewire.extras.instruments import SimulatedFault, SimulatedFaults

__all__ = ["BenchWire", "Converted", "Truth"]

# Step of the simulated wire [s]; it divides every board's tick.
FIRST_READING_S = 1e-3
NOISE_AHEAD = 4096
# Faults that occur at a board's pins; the other faults of a rig file belong to the host.
POSSIBLE = (
    "wire_open",
    "wire_short",
    "bad_contact",
    "clamp_slipped",
    "channel_frozen",
    "channel_saturated",
    "channels_swapped",
    "output_stuck",
    "supply_missing",
)


class Converted(NamedTuple):
    """Codes of the node above the wire and of the shunt's amplifier, 0 to the converter's largest."""

    node: int
    shunt: int


class Truth(NamedTuple):
    """The true state of the wire, with which the tests compare."""

    output_voltage_v: float
    wire_current_a: float
    wire_voltage_v: float
    shunt_voltage_v: float
    temperature_k: float
    displacement_m: float
    strain: float


class BenchWire:
    """A simulated wire with a board's output stage, amplifiers and converter; repeatable for one seed."""

    def __init__(
        self, board: Mapping[str, Any], wire: str, seed: int, settings: Mapping[str, float | str] | None = None
    ) -> None:
        """Cool the wire. ``board`` is what circuit.toml says; ``settings`` change numbers of wire and bench."""
        named = load_wire(wire)
        chosen, bench = with_settings(named, load_bench("paper"), settings or {}, "the emulated board's wire")
        self._board = board
        self._shunt_ohm = bench.shunt_resistance_ohm.value
        self._lead_ohm = bench.lead_resistance_ohm.value
        self._leg_m = bench.wire_length_m.value / bench.legs.value
        spring = SimulatedLoad(spring_load(bench.spring_stiffness_n_per_m.value), 0.0, True, None)
        self._wires = wires_of(SimulatedSpool(chosen, load_alloy(chosen.alloy), bench), (), spring)
        self._random = np.random.default_rng(seed)
        self._noise: list[float] = []
        self._faults: list[SimulatedFault] = []
        self._active: SimulatedFaults | None = None
        # If the emulator has a converter of its own, the bench gives it finer steps and leaves the noise to it.
        self._full = 2 ** int(board.get("bench_bits", board["converter_bits"])) - 1
        self._noise_v = float(board.get("bench_noise_v", board["converter_noise_v"]))
        self.time_s = 0.0
        # A voltage that does not heat shows the resistance before anything is driven.
        self._wire_ohm = self._measured_ohm(self._wires.advance(1e-3, FIRST_READING_S, CHOSEN))

    def _measured_ohm(self, means: Any) -> float:
        return float(means.wire_voltage_v / (means.shunt_voltage_v / self._shunt_ohm))

    def add_faults(self, faults: Sequence[Mapping[str, Any]]) -> None:
        """Add faults, written as in a rig file; ``at`` counts from now on. CallerError for one of another place."""
        # A sound bench needs no extra.
        from musclewire.extras.instruments import SimulatedFault, SimulatedFaults

        for given in faults:
            fault = TypeAdapter(SimulatedFault).validate_python(dict(given))
            if fault.kind not in POSSIBLE:
                raise CallerError(f"a board's bench has no fault '{fault.kind}'; it has: {', '.join(POSSIBLE)}")
            self._faults.append(fault.model_copy(update={"at": self.time_s + fault.at}))
        self._active = SimulatedFaults(self._faults)

    def clear_faults(self) -> None:
        """Repair everything."""
        self._faults.clear()
        self._active = None

    def tick(self, code: int) -> tuple[Converted, Truth]:
        """Hold an output code for one tick; return the conversion at its end, and the truth."""
        board = self._board
        commanded_v = code / (2 ** int(board["output_bits"]) - 1) * board["output_range_v"]
        output_v, between_ohm = commanded_v, self._wire_ohm + self._lead_ohm
        circuit = None
        if self._active is not None:
            output_v = self._active.output_v(commanded_v, self.time_s)
            circuit = self._active.circuit(output_v, between_ohm, self._shunt_ohm, self.time_s)
        current_a = output_v / (between_ohm + self._shunt_ohm) if circuit is None else circuit.wire_current_a
        # The simulated wire has its own shunt in series: this is the drive that sends the circuit's current through it.
        through_v = current_a * (between_ohm + self._shunt_ohm)
        means = self._wires.advance(through_v, float(self._board["tick_period_s"]), CHOSEN)
        if means.shunt_voltage_v > 0.0:
            self._wire_ohm = self._measured_ohm(means)
        wire_v = means.wire_voltage_v if circuit is None else circuit.wire_voltage_v
        shunt_v = means.shunt_voltage_v if circuit is None else circuit.shunt_voltage_v
        self.time_s += board["tick_period_s"]
        truth = Truth(
            output_v,
            means.shunt_voltage_v / self._shunt_ohm,
            wire_v,
            shunt_v,
            self._wires.state.temperature_k,
            means.displacement_m,
            means.displacement_m / self._leg_m,
        )
        if "supply_v" in board:
            wire_v, shunt_v = self._within_a_pulse(float(board["supply_v"]))
        return self._converted(wire_v + shunt_v, shunt_v), truth

    def _within_a_pulse(self, supply_v: float) -> tuple[float, float]:
        """Return the voltages of wire and shunt while a board that switches its supply has it on."""
        between_ohm = self._wire_ohm + self._lead_ohm
        if self._active is not None:
            circuit = self._active.circuit(
                self._active.output_v(supply_v, self.time_s), between_ohm, self._shunt_ohm, self.time_s
            )
            if circuit is not None:
                return circuit.wire_voltage_v, circuit.shunt_voltage_v
        current_a = supply_v / (between_ohm + self._shunt_ohm)
        return current_a * self._wire_ohm, current_a * self._shunt_ohm

    def _converted(self, node_v: float, shunt_v: float) -> Converted:
        """Return the codes of two voltages after divider, amplifier and a converter with noise."""
        inputs_v = (node_v * self._board["divider_share"], shunt_v * self._board["shunt_gain"])
        if self._active is not None:
            inputs_v = self._active.readings_v(*inputs_v, self.time_s)
        codes = []
        for input_v in inputs_v:
            fraction = input_v / self._board["converter_range_v"]
            noise = self._noise_v / self._board["converter_range_v"] * self._next_noise()
            code = round((fraction + noise) * self._full)
            codes.append(min(max(code, 0), self._full))
        return Converted(*codes)

    def _next_noise(self) -> float:
        if not self._noise:
            self._noise = self._random.standard_normal(NOISE_AHEAD).tolist()
        noise = self._noise.pop()
        return 0.0 if self._is_frozen() else noise

    def _is_frozen(self) -> bool:
        # A frozen channel repeats its last code: no noise is added to it.
        return any(fault.kind == "channel_frozen" and fault.active(self.time_s) for fault in self._faults)
