"""A wire of a varied rig along its drive, without instruments: what studies of thousands of wires evaluate."""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.rigs._simulated import stepping_of
from musclewire.rigs._varied_rig import VariedWire
from musclewire.wire import DrivenPath, drive_path


def drive_varied(wire: VariedWire, drive_v: FloatArray) -> tuple[FloatArray, DrivenPath]:
    """Return the drive of a wire as its bench puts it out, and the wire's response; cold at the start.

    Parameters
    ----------
    wire
        The wire.
    drive_v
        Drive voltages [V], one for each sample of its bench, which are held during it.

    Returns
    -------
    The voltages [V] in the steps of the bench's amplifier, (n_samples,), and means and states of all samples.

    Raises
    ------
    CallerError
        For a drive above the wire's maximum, and for steps that do not divide a sample.
    NumericsError
        If the simulation does not resolve what the wire does.
    """
    allowed_v, bench = wire.spool["maximum_voltage_v"], wire.bench
    if drive_v.max() > allowed_v:
        raise CallerError(
            f"the drive of {drive_v.max():g} V is {drive_v.max() - allowed_v:.3g} V above the wire's maximum of "
            f"{allowed_v:g} V: drive less or, if the wire bears it, raise maximum_voltage_v"
        )
    stepping, step_v = stepping_of(bench), bench["amplifier_resolution_v"]
    held_v = np.asarray(step_v * np.round(drive_v / step_v))
    path, _ = drive_path(wire.constants, held_v, sample_s=bench["sample_period_s"], stepping=stepping)
    return held_v, path
