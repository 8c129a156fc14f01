"""The command linearise: operating points, poles and margins of a rig's wire at a displacement."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from musclewire.app import AnswerModel, FigureOptions, Result, RigName, in_si
from musclewire.controllers import PidSettings
from musclewire.errors import require_extra
from musclewire.extras.interfaces._options import DISPLACEMENT, SENSED_BY

if TYPE_CHECKING:
    from musclewire.extras.interfaces._control_systems.operating_points import OperatingPoint
    from musclewire.extras.interfaces._control_systems.study import Linearisation, LinearisedLoop

ZERO_DEGC_K = 273.15


class OperatingPointAnswer(AnswerModel):
    """One operating point."""

    branch: str
    drive_voltage_v: float
    temperature_degc: float
    resistance_ohm: float
    force_n: float
    martensite_fraction: float
    r_phase_fraction: float


class LinearLoopAnswer(AnswerModel):
    """One linear wire with its margins; null for a margin that there is not."""

    branch: str
    motion: str
    pole_per_s: float
    time_constant_s: float
    displacement_m_per_v: float
    resistance_ohm_per_v: float
    temperature_k_per_v: float
    stable: bool
    slowest_s: float | None
    gain_margin: float | None
    phase_margin_deg: float | None
    delay_margin_s: float | None
    crossover_hz: float | None


class LineariseAnswer(AnswerModel):
    """Of ``linearise``."""

    wire: str
    displacement_m: float
    strain_pct: float
    sample_period_s: float
    width_v: float
    operating_points: tuple[OperatingPointAnswer, ...]
    linearisations: tuple[LinearLoopAnswer, ...]
    controller: PidSettings
    sensed_by: str


def linearise(
    rig: RigName,
    displacement: Annotated[str, DISPLACEMENT],
    figure: FigureOptions,
    sensed_by: Annotated[Path | None, SENSED_BY] = None,
) -> Result:
    """Linearise the simulated wire at a displacement: operating points, poles, margins of the closed loop."""
    figure.check()
    require_extra("a system of python-control", "control")
    from musclewire.extras.interfaces._control_systems import study
    from musclewire.sensing import load_model

    model = None if sensed_by is None else load_model(sensed_by)
    found = study.linearise(in_si("--displacement", displacement), rig, model=model)
    figure.draw(partial(study.bode_axes, found))
    return Result(linearisation_answer(found), linearisation_text(found))


def linearisation_answer(found: Linearisation) -> LineariseAnswer:
    """Return a linearisation under the keys of the interface."""
    point = found.points[0]
    return LineariseAnswer.read_from(
        found,
        point,
        point.wire,
        wire=point.wire.name,
        strain_pct=100.0 * point.strain,
        operating_points=[
            OperatingPointAnswer.read_from(one, one.state, temperature_degc=one.temperature_k - ZERO_DEGC_K)
            for one in found.points
        ],
        linearisations=[loop_answer(one) for one in found.loops],
        controller=found.settings,
        sensed_by="strain" if found.model is None else "model",
    )


def loop_answer(one: LinearisedLoop) -> LinearLoopAnswer:
    """Return one linear wire with its margins."""
    linear = one.linear
    return LinearLoopAnswer.read_from(
        one.margins,
        linear,
        branch=linear.point.branch,
        pole_per_s=linear.rate_per_s,
        displacement_m_per_v=linear.steady_per_volt(linear.displacement_m_per_j),
        resistance_ohm_per_v=linear.steady_per_volt(linear.resistance_ohm_per_j),
        temperature_k_per_v=linear.steady_per_volt(linear.temperature_k_per_j),
    )


def linearisation_text(found: Linearisation) -> str:
    """Return a linearisation as lines."""
    point = found.points[0]
    loop = "the strain itself" if found.model is None else "the model's estimate"
    return "\n".join(
        [
            f"{point.wire.name} at {1e3 * point.displacement_m:g} mm, strain {100.0 * point.strain:.3f} %",
            "",
            "reached by | drive V | wire C | ohm     | N",
            *(point_text(one) for one in found.points),
            f"a reversal goes through {found.width_v:.3f} V before the wire follows",
            "",
            "linearised            | pole 1/s | time s | mm/V    | ohm/V   | K/V   | loop",
            *(loop_text(one) for one in found.loops),
            "",
            f"Loop: plain PID, {1e3 * point.wire.sample_period_s:g} ms samples, on {loop}. Branch: onward, with the "
            "transformation.",
            "Minor loop: back, with the wire's own heat capacity; strain hardly moves until the barrier is passed.",
        ]
    )


def point_text(point: OperatingPoint) -> str:
    """Return one operating point as a line."""
    return (
        f"{point.branch:<10} | {point.drive_voltage_v:7.3f} | {point.temperature_k - ZERO_DEGC_K:6.1f} | "
        f"{point.resistance_ohm:7.3f} | {point.force_n:.3f}"
    )


def loop_text(one: LinearisedLoop) -> str:
    """Return one linear wire with its margins as a line."""
    linear = one.linear
    name = f"{linear.point.branch}, {linear.motion}"
    return (
        f"{name:<21} | {linear.rate_per_s:8.3f} | {linear.time_constant_s:6.3f} | "
        f"{1e3 * linear.steady_per_volt(linear.displacement_m_per_j):7.3f} | "
        f"{linear.steady_per_volt(linear.resistance_ohm_per_j):7.3f} | "
        f"{linear.steady_per_volt(linear.temperature_k_per_j):5.1f} | {margins_text(one)}"
    )


def margins_text(one: LinearisedLoop) -> str:
    """Return the margins of a loop in words."""
    margins = one.margins
    if margins.slowest_s is None:
        return "not fed back: the estimate does not move"
    if not margins.stable:
        return f"drifts, time constant {-margins.slowest_s:.3g} s"
    parts = [f"settles in {margins.slowest_s:.3g} s"]
    if margins.gain_margin is not None:
        parts.append(f"gain margin {margins.gain_margin:.2f}")
    if margins.phase_margin_deg is not None and margins.delay_margin_s is not None:
        parts.append(f"phase margin {margins.phase_margin_deg:.0f} deg ({margins.delay_margin_s:.2f} s of delay)")
    return ", ".join(parts)
