"""How an answer about a finger reads: as text, and as keys for JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from musclewire.extras.design._commands.check_text import check_lines

if TYPE_CHECKING:
    from musclewire.extras.design._answers import FingerAnswer
    from musclewire.extras.design._commands.part_options import PartFiles
    from musclewire.extras.design._finger.finger_study import FingerStudyResult

MM, MPA = 1e3, 1e-6


def finger_answer(answer: FingerStudyResult, files: PartFiles) -> FingerAnswer:
    """Return an answer under the keys of the interface."""
    from musclewire.extras.design._answers import FingerAnswer

    geometry, at = answer.geometry, answer.at
    return FingerAnswer.read_from(
        answer,
        at,
        answer.slope,
        stress_max_pa=answer.stress_pa,
        endpoint_m=at.endpoint_displacement_m,
        travel_available_m=answer.study.travel_m,
        pulling_force_n=answer.friction.pulling_n,
        easing_force_n=answer.friction.easing_n,
        friction_share=answer.friction.fraction,
        range_over_length=at.endpoint_displacement_m / geometry.overall_length_m,
        bend_rad=float(at.angles_rad[-1]) - geometry.inward_angle_rad,
        foam=answer.contact,
        holds=all(check.ok for check in answer.checks),
        finger=None if files.output is None else str(files.output),
        drawings=list(map(str, files.drawings)),
        solids=list(map(str, files.solids)),
    )


def answer_text(answer: FingerStudyResult) -> str:
    """Return an answer as lines for people."""
    geometry, at, friction = answer.geometry, answer.at, answer.friction
    lines = [
        f"finger of {answer.study.material.name}, {MM * geometry.overall_length_m:g} mm long, "
        f"{MM * geometry.plate_length_m:g} mm of it plate",
        f"  beam          {MM * geometry.beam_thickness_m:.2f} mm thick, {MM * geometry.beam_depth_m:.2f} mm deep, in "
        f"{geometry.columns} segments of {MM * geometry.segment_length_m:.3f} mm, curved inward by "
        f"{degrees(geometry.inward_angle_rad):.1f} deg in total",
        f"  columns       {geometry.columns}, {MM * geometry.column_width_m:.2f} mm wide, "
        f"{MM * geometry.column_height_m:.2f} mm high; tendon {MM * geometry.tendon_offset_m:.2f} mm from the beam's "
        "middle",
        f"  stiffness     {answer.stiffness_n_per_m:.1f} N/m along the tendon, both legs",
        f"  endpoint      {MM * at.endpoint_displacement_m:.2f} mm at {MM * at.travel_m:.3f} mm of travel, of "
        f"{MM * answer.study.travel_m:g} mm there are; bent by "
        f"{degrees(float(at.angles_rad[-1]) - geometry.inward_angle_rad):.1f} deg",
        f"  tendon        {at.tendon_force_n:.3f} N there without friction; {friction.pulling_n:.3f} N pulling, "
        f"{friction.easing_n:.3f} N easing (friction {answer.study.friction:g})",
        f"  endpoint load 1 N back costs {answer.slope.tendon_force_per_endpoint_force:.2f} N at the tendon and "
        f"{MM * answer.slope.endpoint_compliance_m_per_n:.2f} mm",
        f"  stress        {MPA * answer.stress_pa:.1f} MPa, a strain of "
        f"{100 * answer.stress_pa / geometry.youngs_modulus_pa:.2g} %; {answer.study.material.name} yields at "
        f"{MPA * answer.study.material.yield_stress_pa.value:g} MPa",
    ]
    return "\n".join([*lines, *load_lines(answer), *scheme_lines(answer), "", *check_lines(answer.checks)])


def degrees(angle_rad: float) -> float:
    """Return an angle in degrees."""
    return math.degrees(angle_rad)


def load_lines(answer: FingerStudyResult) -> list[str]:
    """Return what object and wire do, if there are any."""
    lines = []
    contact, wire = answer.contact, answer.wire
    if contact is not None and answer.study.obstacle is not None:
        lines.append(
            f"  object        {answer.study.obstacle.stiffness_n_per_m:g} N/m after "
            f"{MM * answer.study.obstacle.clearance_m:g} mm: {contact.force_n:.3f} N on it at the end of the travel, "
            f"endpoint {MM * contact.endpoint_m:.2f} mm, tendon {contact.tendon_force_n:.2f} N, beam "
            f"{MPA * contact.stress_pa:.0f} MPa (by the linear curve {contact.linear_force_n:.3f} N)"
        )
    if wire is not None and answer.study.wire is not None:
        lines.append(
            f"  wire          {answer.study.wire.name} takes it to {MM * wire.endpoint_m:.2f} mm "
            f"({MM * wire.travel_m:.3f} mm, {100 * wire.contraction:.2f} % of a leg), bearing "
            f"{wire.wire_force_n:.2f} N, {MPA * wire.wire_stress_pa:.0f} MPa; {MM * wire.reserve_m:.3f} mm in reserve"
        )
    return lines


def scheme_lines(answer: FingerStudyResult) -> list[str]:
    """Return the ways to pull the finger as a table, where they were compared."""
    if not answer.schemes:
        return []
    rows = [
        f"  {scheme.name:<28} {scheme.range_over_length:>6.3f} {MM * scheme.endpoint_m:>8.2f} "
        f"{MM * scheme.travel_m:>8.3f} {scheme.tendon_force_n:>8.2f} {MPA * scheme.stress_pa:>6.1f}  {scheme.limit}"
        for scheme in answer.schemes
    ]
    return ["", "  actuation              range/length       mm   travel        N    MPa  used up", *rows]
