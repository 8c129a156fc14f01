"""A recording of a wire driven by a voltage: loops, steps, cooling after a pulse, or any other drive."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from copy import copy

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError, argument
from musclewire.extras.calibration._physical.bench import bench_of
from musclewire.extras.calibration._physical.candidates import WireValues
from musclewire.extras.calibration._physical.observations import (
    FIRST_ROWS,
    REFINED_STEP_S,
    ClockedObservation,
    RawChannel,
    binned,
    binned_channel,
    even_clock,
    instruments_of,
    require_rows,
)
from musclewire.judge import judge_readings, resistance_reading
from musclewire.sensing import noise_level, readings_first
from musclewire.signals import Recording
from musclewire.wire import ConnectorLoad, DrivenPath

# In a recording of a drive the model's error has about this many independent values.
STRETCHES = 20
# A simulated circuit needs some resistance in series with the wire to measure the current; its voltage is negligible.
MIN_SHUNT_OHM = 1e-3
# An amplifier's command counts as its output if both agree to this fraction.
COMMANDED_FRACTION = 0.02
# The least changes by a transformation.
MIN_STROKE = 1e-3  # of strain
MIN_RESISTANCE_CHANGE = 0.01  # of resistance, as a fraction
MIN_OVER_NOISE = 20.0  # of any channel, over its noise
# Strain that begins further from 0 than this fraction of its stroke was not counted from the cold wire.
ZERO_FRACTION = 0.05
# The resistivity of any NiTi lies between these [ohm m]; another one has a wrong unit, diameter or length.
MIN_RESISTIVITY = 0.4e-6
MAX_RESISTIVITY = 2.0e-6


class DrivenObservation(ClockedObservation):
    """A wire at rest and cold that is then driven: its resistance, and the instruments of the recording."""

    def __init__(
        self,
        title: str,
        drive_voltage_v: FloatArray,
        sample_period_s: float,
        bench: Mapping[str, float],
        diameter_m: float | None,
        channels: Mapping[str, RawChannel],
        circuit: Mapping[str, float] | None = None,
    ) -> None:
        """Take a drive on an even clock, (n,), and channels on the same clock.

        ``circuit`` holds the series resistances within the drive voltage if they are not the bench's.
        """
        super().__init__(title, sample_period_s, drive_voltage_v.size, bench, diameter_m)
        self._drive = drive_voltage_v
        self._circuit = dict(circuit or {})
        self._load: ConnectorLoad | None = None
        made = {name: binned_channel(name, raw, self.ticks_s(), self._bin, STRETCHES) for name, raw in channels.items()}
        self._keep = {name: keep for name, (_, keep) in made.items()}
        self.channels = [channel for channel, _ in made.values() if channel.measured.size]

    @property
    def highest_drive_v(self) -> float:
        """The highest absolute voltage of the drive [V]."""
        return float(np.abs(self._drive).max())

    def loaded(self, load: ConnectorLoad | None, uncertain: Collection[str] = ()) -> DrivenObservation:
        """Return the same observation with a load in place of the bench's spring, and uncertain numbers of its bench.

        What is uncertain has the value of the candidate that is simulated.
        """
        other = copy(self)
        other._load = load
        other.bench = {name: value for name, value in self.bench.items() if name not in uncertain}
        return other

    def ticks_s(self) -> FloatArray:
        """Return the times from the start of the recording at which simulated columns are, (n,)."""
        return np.asarray(self._period_s * np.arange(1, self._drive.shape[0] + 1))

    def in_bins(self, name: str, values: FloatArray) -> FloatArray:
        """Return a simulated column, (n,), in the bins of the channel of this name."""
        return binned(values, self._bin)[self._keep[name]]

    def driven_path(self, values: WireValues) -> DrivenPath:
        """Return what this wire does under the recording's drive, sample by sample."""
        return self.path(self.constants(values, self._circuit, self._load), self._drive)

    def columns(self, values: WireValues) -> Mapping[str, FloatArray]:
        """Return the simulated channels of this wire, sample by sample."""
        path = self.driven_path(values)
        bench = {**values.bench, **self.bench, **self._circuit}
        leg_m = bench["wire_length_m"] / bench["legs"]
        # Without current there is no resistance to compare, in the recording neither.
        current_a = np.maximum(path.shunt_voltage_v / bench["shunt_resistance_ohm"], 1e-9)
        return {
            "resistance": path.wire_voltage_v / current_a,
            "strain": path.displacement_m / leg_m,
            "force": path.force_n - bench["pretension_n"],
            "temperature": path.temperature_k,
        }

    def simulate(self, values: WireValues) -> Mapping[str, FloatArray]:
        """Return the simulated channels of this wire, in bins."""
        columns = self.columns(values)
        return {name: self.in_bins(name, columns[name]) for name in self._keep}


def observe_drive(recording: Recording, bench: Mapping[str, float], title: str) -> DrivenObservation:
    """Return a driven recording as an observation, with the user's numbers of the ``bench``.

    Raises RecordingError if nothing was driven, measured or transformed, CallerError if the bench is not known.
    """
    known = bench_of(recording, bench)
    complete = recording.with_metadata({**known, "leg_length_m": known["wire_length_m"] / known["legs"]})
    require_rows(complete)
    drive, circuit = drive_of(complete)
    if float(np.abs(drive).max()) <= 0.0:
        raise RecordingError("the drive is 0 V throughout: a wire at rest identifies no parameter, drive it")
    even, known["sample_period_s"] = even_clock(complete["time_s"])
    channels = channels_of(complete)
    if not channels.keys() & {"resistance", "strain", "force"}:
        raise RecordingError(
            "neither resistance nor strain nor force was recorded: there is nothing to compare, record one of them"
        )
    refuse_idle(channels)
    if "diameter_m" in bench:
        refuse_other_metal(channels, known["wire_length_m"], bench["diameter_m"])
    # Samples closer than the steps of a simulation cost time and add no information: they are averaged.
    group = max(1, int(REFINED_STEP_S / known["sample_period_s"]))
    known["sample_period_s"] *= group
    return DrivenObservation(
        title,
        binned(drive[even], group),
        known["sample_period_s"],
        known,
        bench.get("diameter_m"),
        {name: raw.selected_rows(even).grouped(group) for name, raw in channels.items()},
        circuit,
    )


def refuse_idle(channels: Mapping[str, RawChannel]) -> None:
    """Raise RecordingError if the wire did not transform."""
    if "strain" in channels:
        refuse_strain(channels["strain"].values)
    elif "resistance" in channels:
        raw = channels["resistance"]
        change = float(np.ptp(raw.values[raw.usable]) / np.median(raw.values[raw.usable]))
        if change < MIN_RESISTANCE_CHANGE or not moves(raw):
            raise RecordingError(
                f"no transformation: the resistance changes by {100.0 * change:.2g} % at most: "
                + (
                    readings_first(int(raw.usable.sum()), raw.usable.size)
                    or "drive the wire higher, until it contracts"
                )
            )
    elif not moves(channels["force"]):
        raise RecordingError(
            f"no transformation: the force does not change by more than its noise, {channels['force'].noise[0]:.2g} "
            "N: drive the wire higher, until it contracts"
        )


def refuse_strain(strain: FloatArray) -> None:
    """Raise RecordingError if a strain, (n,), shows no transformation or is not contraction from the cold wire."""
    stroke, noise = float(np.ptp(strain)), noise_level(strain)
    if stroke < max(MIN_STROKE, MIN_OVER_NOISE * noise):
        raise RecordingError(
            f"no transformation: the strain changes by {100.0 * stroke:.2g} % at most, its noise is "
            f"{100.0 * noise:.2g} %: drive the wire higher, until it contracts"
        )
    cold = float(np.median(strain[:FIRST_ROWS]))
    if cold - strain.min() > strain.max() - cold:
        raise RecordingError(
            f"strain of the wrong sign: it falls by {100.0 * (cold - strain.min()):.2g} % from its first value; "
            "contraction counts positive (turn the sign when importing: "
            + argument("invert", True)
            + "), and a recording must begin with a cold wire"
        )
    if abs(cold) > ZERO_FRACTION * stroke:
        raise RecordingError(
            f"strain begins at {100.0 * cold:.3g} %: contraction counts from the cold wire (take off what it reads "
            "cold: " + argument("zero", True) + ")"
        )


def moves(raw: RawChannel) -> bool:
    """Return whether a channel changes by more than its noise."""
    change = float(np.ptp(raw.values[raw.usable]))
    return change > MIN_OVER_NOISE * float(np.median(raw.noise[raw.usable])) + 1e-12


def refuse_other_metal(channels: Mapping[str, RawChannel], length_m: float, diameter_m: float) -> None:
    """Raise RecordingError if the resistivity by resistance, length and diameter is not that of NiTi."""
    if "resistance" not in channels:
        return
    raw = channels["resistance"]
    resistance = float(np.median(raw.values[raw.usable]))
    resistivity = resistance * 0.25 * math.pi * diameter_m**2 / length_m
    if not MIN_RESISTIVITY <= resistivity <= MAX_RESISTIVITY:
        raise RecordingError(
            f"{resistance:.3g} ohm over {1e3 * length_m:.4g} mm of {1e6 * diameter_m:.4g} um wire is a resistivity of "
            f"{resistivity:.2g} ohm m, NiTi has about 0.9e-06: check units, length and diameter "
            "(" + argument("bench", {"diameter_m": "100 um"}) + ")"
        )


def drive_of(recording: Recording) -> tuple[FloatArray, dict[str, float]]:
    """Return the voltage of the circuit, (n,), and the circuit's series resistances if they are not the bench's.

    For a voltage across the wire alone they are negligible. Raises RecordingError if the drive is not recorded.
    """
    names = recording.columns
    refuse_cut_drive(recording)
    shunt_ohm = recording.facts.number_or_none("shunt_resistance_ohm")
    bare = {"shunt_resistance_ohm": MIN_SHUNT_OHM, "lead_resistance_ohm": 0.0}
    if "wire_voltage_v" in names and "shunt_voltage_v" in names and shunt_ohm is not None:
        measured = np.asarray(names["wire_voltage_v"] + names["shunt_voltage_v"])
        commanded = names.get("drive_voltage_v")
        if commanded is not None and np.abs(commanded - measured).max() <= COMMANDED_FRACTION * np.abs(measured).max():
            return commanded, {}
        return measured, {"lead_resistance_ohm": 0.0}
    if "wire_voltage_v" in names:
        return names["wire_voltage_v"], bare
    if "wire_current_a" in names and "wire_resistance_ohm" in names:
        return np.asarray(names["wire_current_a"] * names["wire_resistance_ohm"]), bare
    if "drive_voltage_v" not in names:
        raise RecordingError(
            "the drive of the wire is not recorded: give drive_voltage_v, or wire_voltage_v with shunt_voltage_v or "
            "wire_current_a"
        )
    if shunt_ohm is None:
        raise RecordingError(
            "drive_voltage_v is across wire and shunt, and the shunt is not known: give shunt_resistance_ohm in its "
            "metadata, 0 for none"
        )
    return names["drive_voltage_v"], {"shunt_resistance_ohm": max(shunt_ohm, MIN_SHUNT_OHM)}


def refuse_cut_drive(recording: Recording) -> None:
    """Raise RecordingError if the voltage across the wire is not known in some rows, and so not what heated it."""
    for item in judge_readings(recording.columns, recording.metadata, ("wire_voltage_v",)).found:
        if not item.is_real:
            raise RecordingError(
                f"the drive of the wire is not known in {int(item.rows.sum())} of {item.rows.size} rows: {item.why}"
            )


def channels_of(recording: Recording) -> dict[str, RawChannel]:
    """Return the channels of a recording by their names in a simulation."""
    found = {}
    names = set(recording.names)
    if "wire_resistance_ohm" in names or ("wire_voltage_v" in names and names & {"shunt_voltage_v", "wire_current_a"}):
        reading = resistance_reading(recording)
        found["resistance"] = RawChannel("ohm", reading.resistance_ohm, resistance_noise(recording), reading.valid)
    return found | instruments_of(recording)


def resistance_noise(recording: Recording) -> FloatArray:
    """Return the standard deviation of each resistance [ohm], (n,): noise of both readings over their size."""
    other = next((name for name in ("shunt_voltage_v", "wire_current_a") if name in recording), None)
    if "wire_voltage_v" not in recording or other is None:
        return np.full(len(recording), noise_level(recording["wire_resistance_ohm"]))
    relative_variance = np.zeros(len(recording))
    for name in ("wire_voltage_v", other):
        relative_variance += (noise_level(recording[name]) / np.maximum(np.abs(recording[name]), 1e-9)) ** 2
    return np.asarray(np.sqrt(relative_variance) * np.abs(resistance_reading(recording).resistance_ohm))
