"""A slow sine with its gaps and branches."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from musclewire.arrays import FloatArray
from musclewire.experiment import WithTruth, determined, run_on_rig, slow_sine_run
from musclewire.identify import LoopGaps, loop_gaps, required_quantity
from musclewire.judge import resistance_reading
from musclewire.rigs import Rig, required_true_state
from musclewire.sensing import Branch, single_valued
from musclewire.signals import Recording

CYCLES = 2
# Recorded with the voltages, and taken out of the recording: what is to be found must not be in it.
TRUE_RESISTANCE, TRUE_TEMPERATURE = "wire_resistance_ohm", "wire_temperature_k"
TRUE_STATE = {TRUE_RESISTANCE: "resistance_ohm", TRUE_TEMPERATURE: "temperature_k"}


@dataclass(frozen=True, eq=False)
class SlowSineLoop:
    """A slow sine with its gaps; the wire's own resistance and temperature at each sample's end, (n_times,)."""

    recording: Recording
    gaps: LoopGaps
    true_resistance_ohm: FloatArray
    true_temperature_k: FloatArray

    @cached_property
    def resistance_ohm(self) -> FloatArray:
        """Resistance by Eq. 1, (n_times,)."""
        return resistance_reading(self.recording).resistance_ohm

    def quantity(self, name: str) -> FloatArray:
        """Return strain, displacement [m] or contraction force [N], (n_times,)."""
        return required_quantity(self.recording, name)

    @property
    def strain_gap_pct(self) -> float:
        """Eq. 2 for strain."""
        return 100.0 * self.gaps.strain_gap

    @property
    def force_gap_pct(self) -> float:
        """Eq. 2 for force; the simulated rig always has a load cell."""
        return 100.0 * determined(self.gaps.force_gap, "the gap of force")

    @property
    def displacement_gap_pct(self) -> float:
        """Eq. 9: the gap of displacement: of a finger's endpoint if there is one, else of the connector."""
        return 100.0 * determined(self.gaps.displacement_gap, "the gap of displacement")

    @property
    def stroke_pct(self) -> float:
        """Largest strain minus cold strain."""
        return 100.0 * (self.gaps.segments.strain_max - self.gaps.segments.strain_cold)

    def halves(self) -> tuple[slice, slice]:
        """Return heating A to C and cooling C to A of the analysed cycle, as row slices."""
        found = self.gaps.segments
        return slice(found.heating_a, found.heating_c + 1), slice(found.cooling_c, found.cooling_a + 1)

    def sensing_branches(self, quantity: str) -> tuple[Branch, Branch]:
        """Return heating and cooling from B to C as single-valued curves over resistance."""
        found, values = self.gaps.segments, self.quantity(quantity)
        heating = slice(found.heating_b, found.heating_c + 1)
        cooling = slice(found.cooling_c, found.cooling_b + 1)
        up, down = (
            single_valued((self.resistance_ohm[part], values[part]), name)
            for part, name in ((heating, "heating"), (cooling, "cooling"))
        )
        return up, down


def loop_on(rig: Rig, amplitude_v: float | None = None) -> SlowSineLoop:
    """Return the slow sine of an open rig, with the true resistance and temperature of the simulated wire."""
    sine = slow_sine_run(rig, amplitude_v, cycles=CYCLES)
    policy = WithTruth(sine.policy, required_true_state(rig), TRUE_STATE)
    whole = run_on_rig(rig, policy, sine.duration_s, metadata=sine.metadata)
    columns = {name: column for name, column in whole.columns.items() if name not in TRUE_STATE}
    recording = Recording(columns, whole.metadata)
    return SlowSineLoop(recording, loop_gaps(recording), whole[TRUE_RESISTANCE], whole[TRUE_TEMPERATURE])
