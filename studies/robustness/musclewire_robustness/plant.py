"""The plant of the benchmark: a wire of the population on its rig, with what disturbs it and its instruments."""

from __future__ import annotations

import numpy as np

from musclewire import GuardedRig, load_alloy, load_wire
from musclewire.extras.studies import (
    Conditions,
    InstrumentSettings,
    LocalDraughts,
    SegmentedDevice,
    SegmentedSpool,
    steady,
)
from musclewire.parameters import Wire
from musclewire_robustness.population import PopulationWire
from musclewire_robustness.settings import Condition, RunSettings, settings

AS_CHARACTERIZED = Condition(name="as characterized", bar="none")


class Disturbance:
    """A condition over time: it is there as far as a ramp says, which begins when ``change_at`` has said so.

    Parameters
    ----------
    wire
        The wire; its pretension is what fractions of a load refer to.
    condition
        What changes.
    run
        Times of a run.
    """

    def __init__(self, wire: PopulationWire, condition: Condition, run: RunSettings) -> None:
        """Begin with nothing changed, but for what has drifted before a home move."""
        self._condition, self._run = condition, run
        self._ambient_k = wire.bench.ambient_temperature_k.value
        self._pretension_n = wire.bench.pretension_n.value
        self._change_at_s: float | None = None
        self._draughts: LocalDraughts | None = None
        if condition.draughts:
            number = wire.structure.n_segments
            self._draughts = LocalDraughts(steady(), number, strength=condition.draughts, seed=wire.seed)

    def change_at(self, time_s: float) -> None:
        """Let the change begin at a time on the rig's clock [s]."""
        self._change_at_s = time_s

    def level(self, time_s: float) -> float:
        """Return how much of a change during the run is there at a time [s], from 0 to 1."""
        if self._condition.zeroed:
            return 1.0
        if self._change_at_s is None:
            return 0.0
        duration_s = self._run.drift_s if self._condition.drift else self._run.ramp_s
        return min(max((time_s - self._change_at_s) / duration_s, 0.0), 1.0)

    def drift_level(self, time_s: float) -> float:
        """Return how much of what can drift is there: all of it from the beginning in rows with a home move."""
        return 1.0 if self._condition.home else self.level(time_s)

    def lead_ohm(self, time_s: float) -> float:
        """Return the resistance of the leads at a time [s]."""
        return self._condition.lead_ohm * self.drift_level(time_s)

    def ambient_k(self, time_s: float) -> float:
        """Return the temperature of the air at a time [K]."""
        return self._ambient_k + self.drift_level(time_s) * self._condition.ambient_k

    def __call__(self, time_s: float) -> Conditions:
        """Return what is around the wire at a time on the rig's clock [s]."""
        condition, level, drifted = self._condition, self.level(time_s), self.drift_level(time_s)
        convection = condition.convection_factor**drifted
        along = np.asarray(convection)
        if self._draughts is not None:
            along = convection * (1.0 + level * (np.asarray(self._draughts(time_s).convection_factor) - 1.0))
        return Conditions(
            ambient_k=self.ambient_k(time_s),
            convection_factor=along,
            load_force_n=level * condition.load_fraction * self._pretension_n,
            stiffness_factor=condition.stiffness_factor**level,
            pretension_force_n=level * condition.pretension_fraction * self._pretension_n,
            resistance_factor=1.0 + drifted * (condition.resistance_factor - 1.0),
            transformation_shift_k=drifted * condition.transformation_shift_k,
        )


# A lead that drifts is another lead once a second.
LEAD_EVERY_S = 1.0
# Seeds of the runs of a wire, and of its instruments after each of those seconds, lie apart.
RUNS_PER_WIRE, LEADS_PER_RUN = 100, 10_000
# A contracted wire has this part of the maker's ohm per metre.
CONTRACTED = 0.85


class DisturbedPlant:
    """An open rig, with the disturbance that changes what is around its wire.

    Parameters
    ----------
    device
        The device in segments.
    disturbance
        What changes around the wire.
    lead_drifts
        Whether the resistance of the leads changes while a run lasts.
    seed
        Seed of the run.

    Attributes
    ----------
    rig
        The guarded rig.
    disturbance
        What changes.
    seed
        Seed of the run.
    """

    def __init__(self, device: SegmentedDevice, disturbance: Disturbance, lead_drifts: bool, seed: int) -> None:
        """Guard the device."""
        self.rig, self.disturbance = GuardedRig(device), disturbance
        self.rig.air_is_stated = True  # its user sees that it hangs bare: its grains turn below the alloy's temperature
        self._device, self._lead_drifts, self.seed = device, lead_drifts, seed
        self._instruments, self._leads = device.instruments, 0

    def take_zero(self, rest_s: float) -> None:
        """Let the wire rest [s] under what is there, and take the zero of its displacement again."""
        for _ in range(round(rest_s / self.rig.sample_period_s)):
            self.rig.exchange(self.rig.sense_voltage_v)
        self._device.zero_displacement()

    def before_sample(self) -> None:
        """Let the leads drift before the next sample: other instruments once a second, with noise of their own."""
        if not self._lead_drifts:
            return
        time_s = self._device.wire_state.time_s
        if time_s >= self._leads * LEAD_EVERY_S:
            self._leads += 1
            changed = self._instruments._replace(lead_resistance_ohm=self.disturbance.lead_ohm(time_s))
            self._device.exchange_instruments(changed, self.seed * LEADS_PER_RUN + self._leads)


def open_plant(wire: PopulationWire, condition: Condition = AS_CHARACTERIZED, *, run: int = 0) -> DisturbedPlant:
    """Return a wire on its rig, cold, before anything changes.

    Parameters
    ----------
    wire
        The wire.
    condition
        What will change; nothing by default.
    run
        Number of the run of this wire: each has a noise of its own.

    Returns
    -------
    Rig and disturbance.
    """
    known = settings()
    coarse = condition.bits is not None
    ratio = known.rig.board_voltage_ratio if coarse else known.rig.maximum_voltage_ratio
    allowed_v = wire.wire.drive_amplitude_v.value * ratio
    spool = SegmentedSpool(allowing(wire.wire, allowed_v), wire.alloy, wire.bench, wire.structure)
    disturbance = Disturbance(wire, condition, known.run)
    instruments = instruments_of(wire, condition, disturbance, largest_shunt_v(wire, allowed_v))
    seed = RUNS_PER_WIRE * wire.seed + run
    limits = limits_of_user(wire, instruments, condition)
    device = SegmentedDevice(spool, conditions=disturbance, instruments=instruments, seed=seed, limits=limits)
    return DisturbedPlant(device, disturbance, condition.lead_ohm > 0.0 and not condition.home, seed)


def allowing(wire: Wire, maximum_v: float) -> Wire:
    """Return a wire on a rig that allows another drive voltage [V]."""
    return wire.model_copy(update={"maximum_voltage_v": wire.maximum_voltage_v.model_copy(update={"value": maximum_v})})


def limits_of_user(wire: PopulationWire, instruments: InstrumentSettings, condition: Condition) -> dict[str, float]:
    """Return the limits of the protection that the user has set: by the wire he believes to have."""
    known = settings().rig
    named = load_wire(wire.base)
    believed = SegmentedDevice(SegmentedSpool(named, load_alloy(named.alloy), wire.bench), instruments=instruments)
    usual = believed.facts.limits
    found = {
        "heat_capacity_j_per_k": usual.heat_capacity_j_per_k,
        "heat_loss_w_per_k": usual.heat_loss_w_per_k,
    }
    if condition.convection_factor > 1.0 or condition.draughts:
        found["maximum_temperature_k"] = known.moving_air_limit_k
    if condition.bits is not None or condition.noise_factor > 1.0:
        found["jump_share"] = known.noisy_jump_fraction
    return found


def instruments_of(
    wire: PopulationWire, condition: Condition, disturbance: Disturbance, largest_v: float
) -> InstrumentSettings:
    """Return the bench's instruments with what a condition changes."""
    own = InstrumentSettings.of_bench(wire.bench.values())
    shunt_v = own.shunt_range_v if condition.shunt_range_v is None else condition.shunt_range_v
    while condition.shunt_range_v is not None and shunt_v < largest_v:
        shunt_v *= 2.0  # a board for a thicker wire has less gain
    return own._replace(
        voltage_noise_v=own.voltage_noise_v * condition.noise_factor,
        bits=condition.bits or own.bits,
        wire_range_v=condition.wire_range_v or own.wire_range_v,
        shunt_range_v=shunt_v,
        bipolar=not condition.one_sided,
        readings=condition.readings or own.readings,
        clock_jitter=condition.jitter,
        contact_jump_ohm=condition.contact_fraction * nominal_ohm(wire),
        lead_resistance_ohm=disturbance.lead_ohm(0.0),
    )


def nominal_ohm(wire: PopulationWire) -> float:
    """Return the resistance of a wire by the maker's ohm per metre [ohm]."""
    return wire.wire.resistance_per_metre_ohm_per_m.value * wire.bench.wire_length_m.value


def largest_shunt_v(wire: PopulationWire, drive_v: float) -> float:
    """Return the voltage at the shunt at the largest drive [V]."""
    shunt_ohm = wire.bench.shunt_resistance_ohm.value
    return drive_v * shunt_ohm / (CONTRACTED * nominal_ohm(wire) + shunt_ohm)
