"""Margins of a closed loop: a linear wire between samples, and the plain PID that this package's loops run."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, log, pi
from typing import Any

import control
import numpy as np

from musclewire.controllers import PidSettings
from musclewire.extras.interfaces._control_systems.linearisation import LinearWire
from musclewire.sensing import SensingModel


@dataclass(frozen=True)
class LoopMargins:
    """How far a loop is from the limit of stability."""

    stable: bool  # whether all closed-loop poles are inside the unit circle
    # Time constant of the slowest closed-loop pole; below 0 for the fastest growth of a loop that is not stable, None
    # if nothing is fed back.
    slowest_s: float | None
    # Factor on the loop's gain at which it begins to oscillate; None if there is none, or the loop is not stable.
    gain_margin: float | None = None
    # Phase that may be lost at the crossover; None without a crossover, or if the loop is not stable.
    phase_margin_deg: float | None = None
    delay_margin_s: float | None = None  # delay that this phase is at the crossover; None as the phase margin
    crossover_hz: float | None = None  # frequency at which the loop's gain is 1; None as the phase margin


def sampled_system(linear: LinearWire, period_s: float, model: SensingModel | None = None) -> Any:
    """Return the ``control.StateSpace`` from drive [V] held over a sample to mean strain in the sample that has ended.

    Both are relative to the operating point. With a model the output is its estimate of strain.
    """
    sampled = linear.sampled(period_s)
    per_j = linear.strain_per_j if model is None else linear.estimate_per_j(model)
    return control.ss(
        [[sampled.kept, 0.0], [per_j * sampled.mean_kept, 0.0]],
        [[sampled.driven], [per_j * sampled.mean_driven]],
        [[0.0, 1.0]],
        [[0.0]],
        period_s,
        inputs=["drive_voltage_v"],
        outputs=["strain"],
    )


def controller_system(settings: PidSettings, period_s: float) -> Any:
    """Return the ``control.TransferFunction`` of ``pid`` from strain error to drive voltage, away from its limits."""
    z = control.tf([1.0, 0.0], [1.0], period_s)
    weight = period_s / (settings.derivative_filter_s + period_s)
    rate = (weight / period_s) * (z - 1.0) / (z - (1.0 - weight))
    law = settings.kp + settings.ki * period_s * z / (z - 1.0) + settings.kd * rate
    return control.minreal(settings.input_scale / settings.error_unit * law, verbose=False)


def loop_margins(
    linear: LinearWire,
    settings: PidSettings | None = None,
    model: SensingModel | None = None,
    period_s: float | None = None,
) -> LoopMargins:
    """Return the margins of a closed loop at an operating point.

    Parameters
    ----------
    linear
        The wire, linearised there.
    settings
        Those of the plain PID; its defaults, the middles of the paper's ranges, if None.
    model
        Model by which the loop senses strain; None closes it on the strain itself.
    period_s
        Time between samples [s]; the rig's if None.

    Returns
    -------
    The margins.

    Raises
    ------
    CallerError
        For settings that a PID cannot have.
    """
    dt_s = linear.point.wire.sample_period_s if period_s is None else period_s
    loop = control.ss(controller_system(settings or PidSettings(), dt_s)) * sampled_system(linear, dt_s, model)
    largest = float(np.abs(control.feedback(loop, 1).poles()).max())
    slowest_s = -dt_s / log(largest) if largest != 1.0 else None
    if largest >= 1.0:
        return LoopMargins(False, slowest_s)
    gain, phase_deg, _, _, crossover, _ = (float(number) for number in control.stability_margins(loop))
    gain_margin = gain if isfinite(gain) else None
    if not isfinite(crossover):
        return LoopMargins(True, slowest_s, gain_margin)
    crossover_hz = crossover / (2.0 * pi)
    return LoopMargins(True, slowest_s, gain_margin, phase_deg, phase_deg / 360.0 / crossover_hz, crossover_hz)
