"""Many simulated wires along their drives, without instruments: what studies of thousands of wires evaluate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, NumericsError
from musclewire.rigs._simulated import stepping_of
from musclewire.rigs._varied_rig import VariedWire
from musclewire.wire import MAX_STEP_ERROR_K, StepControl, WireBatch, require_resolved

__all__ = ["WirePath", "drive_wires", "held_voltages_v"]


class WirePath(NamedTuple):
    """Response of a wire to its drive, each (n_samples,).

    Parameters
    ----------
    wire_voltage_v
        Voltage of the wire [V], mean over each sample.
    shunt_voltage_v
        Voltage of the shunt [V], mean over each sample.
    displacement_m
        Displacement of the connector [m], mean over each sample.
    force_n
        Force of all legs together [N], mean over each sample.
    temperature_k
        Temperature at the end of each sample [K].
    """

    wire_voltage_v: FloatArray
    shunt_voltage_v: FloatArray
    displacement_m: FloatArray
    force_n: FloatArray
    temperature_k: FloatArray


def held_voltages_v(drive_v: FloatArray, wire: VariedWire) -> FloatArray:
    """Return drive voltages in the steps of the bench's amplifier, as its rig puts them out [V], (n_samples,).

    Raises CallerError for a drive above the wire's maximum, and for steps that do not divide a sample.
    """
    allowed_v = wire.spool["maximum_voltage_v"]
    if drive_v.max() > allowed_v:
        raise CallerError(
            f"the drive of {drive_v.max():g} V is {drive_v.max() - allowed_v:.3g} V above the wire's maximum of "
            f"{allowed_v:g} V: drive less or, if the wire bears it, raise maximum_voltage_v"
        )
    stepping_of(wire.bench)
    step_v = wire.bench["amplifier_resolution_v"]
    return np.asarray(step_v * np.round(drive_v / step_v))


def drive_wires(wires: Sequence[VariedWire], drives_v: Sequence[FloatArray]) -> list[WirePath | NumericsError]:
    """Return the response of each wire to its own drive, held for its bench's sample period; cold at the start.

    Parameters
    ----------
    wires
        The wires.
    drives_v
        Drive voltages [V] of each wire, one for each of its samples.

    Returns
    -------
    For each wire its response, which is the same whatever the others are, or that the simulation does not resolve it.
    """
    alike: dict[tuple[object, ...], list[int]] = {}
    for place, (wire, drive_v) in enumerate(zip(wires, drives_v, strict=True)):
        key = (stepping_of(wire.bench), wire.bench["sample_period_s"], drive_v.size, wire.constants.classes)
        alike.setdefault(key, []).append(place)
    found: dict[int, WirePath | NumericsError] = {}
    for places in alike.values():
        batch = driven([wires[place] for place in places], np.stack([drives_v[place] for place in places]))
        found |= dict(zip(places, batch, strict=True))
    return [found[place] for place in range(len(wires))]


def driven(wires: Sequence[VariedWire], drives_v: FloatArray) -> list[WirePath | NumericsError]:
    """Return the responses of wires with the same samples and steps, drives (n_wires, n_samples)."""
    stepping, sample_s = stepping_of(wires[0].bench), wires[0].bench["sample_period_s"]
    # One thread: whoever has many wires divides them among processes, which also do what is no compiled code.
    batch = WireBatch([wire.constants for wire in wires], stepping=stepping, threads=1)
    columns = batch.drive(drives_v, sample_s, WirePath._fields)
    lost = lost_wires(batch, stepping, sample_s)
    paths = (WirePath(*row) for row in zip(*(columns[name] for name in WirePath._fields), strict=True))
    return [lost.get(place, path) for place, path in enumerate(paths)]


def lost_wires(batch: WireBatch, stepping: StepControl, sample_s: float) -> dict[int, NumericsError]:
    """Return the error of each wire that the simulation has not resolved, by its place."""
    states = batch.states
    # Not a number is not below anything: written so that it counts as not resolved.
    sound = (states["unsolved_steps"] == 0.0) & (states["step_error_k"] <= MAX_STEP_ERROR_K)
    lost: dict[int, NumericsError] = {}
    for place in np.flatnonzero(~(sound & np.isfinite(states["temperature_k"]))).tolist():
        try:
            require_resolved(batch.state(place), stepping, sample_s)
        except NumericsError as error:
            lost[place] = error
    return lost
