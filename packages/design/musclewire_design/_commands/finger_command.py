"""``musclewire design finger``: from what a finger must do to its dimensions, or from dimensions to what it does."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app import CLEARANCE, OBJECT_STIFFNESS, WIRE, WIRE_LENGTH, Result, in_si, warn
from musclewire.errors import CallerError
from musclewire_design._commands.check_text import check_lines
from musclewire_design._commands.part_options import OPTIONS_FILE, PartFiles, given_options
from musclewire_design._options import (
    COLUMN_WIDTH,
    COLUMNS,
    COMPARE,
    DEPTH,
    ENDPOINT,
    FINGER,
    FRICTION,
    INWARD_ANGLE,
    MATERIAL,
    MAX_DEPTH,
    OFFSET,
    OVERALL_LENGTH,
    PLATE,
    PRETENSION,
    PRETENSIONER,
    PROCESS,
    REFINED,
    STIFFNESS,
    TENDON_HOLE,
    THICKNESS,
    TRAVEL,
)

if TYPE_CHECKING:
    from musclewire.parameters import Material
    from musclewire.wire import ElasticObject
    from musclewire_design._answers import FingerAnswer
    from musclewire_design._commands.part_options import PartFiles
    from musclewire_design._finger.finger_study import FingerStudyResult, WireToPull
    from musclewire_design._finger.geometry import FingerGeometry
    from musclewire_design._finger.sizing import FingerRequest


@dataclass(frozen=True)
class SectionOptions:
    """Which finger is meant: one to size, one from a file, or one of given dimensions."""

    stiffness: Annotated[str | None, STIFFNESS] = None
    finger: Annotated[str | None, FINGER] = None
    thickness: Annotated[str | None, THICKNESS] = None
    offset: Annotated[str | None, OFFSET] = None
    depth: Annotated[str, DEPTH] = "5 mm"
    max_depth: Annotated[str, MAX_DEPTH] = "10 mm"

    def require_one_way(self) -> None:
        """Raise CallerError unless exactly one of the ways to say which finger is meant was taken."""
        ways = {"--stiffness": self.stiffness, "--finger": self.finger, "--thickness": self.thickness}
        taken = [name for name, value in ways.items() if value is not None]
        if not taken:
            raise CallerError(f"say which finger: {WAYS}")
        if len(taken) > 1:
            raise CallerError(f"{' and '.join(taken)} exclude each other: give one of them")
        if (self.offset is None) != (self.thickness is None):
            raise CallerError("--thickness and --offset belong together: give both, or neither")


@dataclass(frozen=True)
class BeamOptions:
    """The dimensions of a finger besides those of its section."""

    overall_length: Annotated[str, OVERALL_LENGTH] = "10 mm"
    plate: Annotated[str, PLATE] = "5 mm"
    columns: Annotated[int, COLUMNS] = 4
    column_width: Annotated[str, COLUMN_WIDTH] = "0.3 mm"
    inward_angle: Annotated[str, INWARD_ANGLE] = "8 deg"

    def in_si(self) -> dict[str, float]:
        """Return lengths and angle by the names of ``FingerRequest`` and ``FingerGeometry``."""
        return {
            "overall_length_m": in_si("--overall-length", self.overall_length),
            "plate_length_m": in_si("--plate", self.plate),
            "column_width_m": in_si("--column-width", self.column_width),
            "inward_angle_rad": in_si("--inward-angle", self.inward_angle),
        }


@dataclass(frozen=True)
class TaskOptions:
    """What the finger must do, and what it is made of."""

    endpoint: Annotated[str, ENDPOINT] = "6 mm"
    travel: Annotated[str, TRAVEL] = "1.05 mm"
    material: Annotated[str, MATERIAL] = "pom"
    process: Annotated[str | None, PROCESS] = None
    friction: Annotated[float, FRICTION] = 0.15
    tendon_hole: Annotated[str, TENDON_HOLE] = "0.3 mm"


@dataclass(frozen=True)
class ObstacleOptions:
    """An object in the way of the endpoint."""

    object_stiffness: Annotated[str | None, OBJECT_STIFFNESS] = None
    clearance: Annotated[str, CLEARANCE] = "4 mm"

    def to_touch(self) -> ElasticObject | None:
        """Return the object, None without one."""
        from musclewire.wire import ElasticObject

        stiffness = in_si("--object-stiffness", self.object_stiffness)
        return None if stiffness is None else ElasticObject(stiffness, in_si("--clearance", self.clearance))


@dataclass(frozen=True)
class WireOptions:
    """The wire whose stroke and force are checked, and the pretensioner on its connector."""

    wire: Annotated[str | None, WIRE] = None
    wire_length: Annotated[str, WIRE_LENGTH] = "7 cm"
    pretension: Annotated[str, PRETENSION] = "0.71 N"
    pretensioner: Annotated[str, PRETENSIONER] = "386.2 N/m"

    def to_pull(self) -> WireToPull | None:
        """Return the wire, None without one."""
        from musclewire.parameters import read_pretensioner
        from musclewire_design._finger.finger_study import WireToPull

        if self.wire is None:
            return None
        if self.pretensioner.endswith(".toml"):
            stiffness = read_pretensioner(self.pretensioner).stiffness_n_per_m
        else:
            stiffness = in_si("--pretensioner", self.pretensioner)
        return WireToPull(
            self.wire, in_si("--wire-length", self.wire_length), in_si("--pretension", self.pretension), stiffness
        )


def finger(
    context: typer.Context,
    section: SectionOptions,
    beam: BeamOptions,
    task: TaskOptions,
    obstacle: ObstacleOptions,
    wire: WireOptions,
    files: PartFiles,
    options_file: Annotated[Path | None, OPTIONS_FILE] = None,
    compare: Annotated[bool, COMPARE] = False,
    refined: Annotated[int, REFINED] = 1,
) -> Result:
    """Size a tendon-driven flexible finger, or compute what one of given dimensions does."""
    del options_file  # its values have become those of the options
    files.require("finger")
    from musclewire.parameters import load_material
    from musclewire_design._finger.finger_study import FingerStudy, study_finger

    section.require_one_way()
    require_effect(context, section, obstacle, wire)
    material = load_material(task.material)
    request = requested(section, beam, task, material) if section.stiffness is not None else None
    geometry = None if request is not None else geometry_of(section, beam, task, material)
    answer = study_finger(
        FingerStudy(
            material=material,
            endpoint_m=in_si("--endpoint", task.endpoint),
            travel_m=in_si("--travel", task.travel),
            request=request,
            geometry=geometry,
            friction=task.friction,
            obstacle=obstacle.to_touch(),
            wire=wire.to_pull(),
            compare=compare,
            refined=refined,
        )
    )
    hole_m = in_si("--tendon-hole", task.tendon_hole) or 0.0
    if "tendon_hole" in given_options(context):
        require_tendon_holes(answer.geometry, hole_m)
    write_files(answer, files, hole_m)
    warn([*answer.warnings, *(f"it does not hold: {one.name}" for one in answer.checks if not one.ok)])
    shown = finger_answer(answer, files)
    return Result(shown, answer_text(answer), holds=shown.holds)


# Batches and sheets of one material differ by less.
MODULUS_MARGIN = 0.3
# Film and thin strip are sold from about here.
MIN_THICKNESS_M = 0.1e-3
WAYS = "--stiffness '1084.4 N/m' to size one, --finger NAME for one that exists, or --thickness and --offset"
# What an option needs to change anything, and what a finger's file has already.
NEEDS = {
    "clearance": "--object-stiffness",
    "wire_length": "--wire",
    "pretension": "--wire",
    "pretensioner": "--wire",
    "max_depth": "--stiffness",
}
OF_A_FILE = ("depth", "overall_length", "plate", "columns", "column_width", "inward_angle", "process")


def require_effect(
    context: typer.Context, section: SectionOptions, obstacle: ObstacleOptions, wire: WireOptions
) -> None:
    """Raise CallerError for an option that was given and would change nothing with the others as they are."""
    others = {
        "--stiffness": section.stiffness,
        "--wire": wire.wire,
        "--object-stiffness": obstacle.object_stiffness,
    }
    for name in given_options(context):
        option = f"--{name.replace('_', '-')}"
        if name in NEEDS and others[NEEDS[name]] is None:
            raise CallerError(f"{option} has an effect only with {NEEDS[name]}: give that too, or leave it out")
        if name in OF_A_FILE and section.finger is not None:
            raise CallerError(
                f"{option} and --finger exclude each other: a finger's file has all dimensions, leave one out"
            )


def requested(section: SectionOptions, beam: BeamOptions, task: TaskOptions, material: Material) -> FingerRequest:
    """Return the request for a finger: stiffness, endpoint and travel wanted, and the room for its section."""
    from musclewire_design._finger.sizing import FingerRequest

    thinnest_m = material.minimum_thickness_by(task.process) if task.process else MIN_THICKNESS_M
    return FingerRequest(
        stiffness_n_per_m=in_si("--stiffness", section.stiffness) or 0.0,
        endpoint_m=in_si("--endpoint", task.endpoint),
        travel_m=in_si("--travel", task.travel),
        columns=beam.columns,
        depth_m=in_si("--depth", section.depth),
        max_depth_m=in_si("--max-depth", section.max_depth),
        min_thickness_m=thinnest_m,
        **beam.in_si(),
    )


def geometry_of(section: SectionOptions, beam: BeamOptions, task: TaskOptions, material: Material) -> FingerGeometry:
    """Return the geometry of a finger's file, or of given thickness, depth and offset."""
    if section.finger is not None:
        geometry = geometry_from_file(section.finger)
        require_material_of(geometry, section.finger, material)
        return geometry
    from musclewire_design._finger.sizing import geometry_of_section

    geometry = geometry_of_section(
        in_si("--thickness", section.thickness) or 0.0,
        in_si("--depth", section.depth),
        in_si("--offset", section.offset) or 0.0,
        beam.in_si(),
        beam.columns,
        material.youngs_modulus_pa.value,
    )
    if task.process is not None:
        require_made(geometry, task.process, material.minimum_thickness_by(task.process))
    return geometry


def require_material_of(geometry: FingerGeometry, file: str, material: Material) -> None:
    """Raise CallerError if a finger file is of a material much stiffer or softer than the one it is computed with."""
    own, other = geometry.youngs_modulus_pa, material.youngs_modulus_pa.value
    if abs(own / other - 1.0) > MODULUS_MARGIN:
        raise CallerError(
            f"finger {file} is of {1e-9 * own:g} GPa, and {material.name} has {1e-9 * other:g} GPa: name its own "
            "--material, or compute another by --thickness and --offset"
        )


def require_made(geometry: FingerGeometry, process: str, minimum_m: float) -> None:
    """Raise CallerError for a beam thinner than a process makes it."""
    if geometry.beam_thickness_m < minimum_m:
        beam_m = geometry.beam_thickness_m
        raise CallerError(
            f"a beam of {1e3 * beam_m:g} mm is {100 * (1 - beam_m / minimum_m):.0f} % thinner than the "
            f"{1e3 * minimum_m:g} mm that {process} makes: a thicker beam or another process"
        )


def geometry_from_file(name: str) -> FingerGeometry:
    """Return the geometry of a finger by name or file."""
    from musclewire.parameters import load_finger
    from musclewire_design._finger.finger_file_text import finger_geometry

    return finger_geometry(load_finger(name))


def require_tendon_holes(geometry: FingerGeometry, diameter_m: float) -> None:
    """Raise CallerError for tendon holes that do not fit, whether or not a solid is written."""
    from musclewire_design._finger.drawing import require_room

    require_room(geometry, diameter_m)


def write_files(answer: FingerStudyResult, files: PartFiles, tendon_hole_m: float) -> None:
    """Write what was requested, each file whole or not at all."""
    from musclewire.signals import write_text_whole, write_whole

    if files.output is not None:
        from musclewire_design._finger.finger_file_text import finger_study_file_text

        write_text_whole(files.output, finger_study_file_text(files.output.stem, answer))
    for drawing in files.drawings:
        from musclewire_design._finger.drawing import write_finger_drawing

        write_finger_drawing(answer.geometry, drawing)
    for solid in files.solids:
        from musclewire_design._finger.drawing import write_finger_solid

        write_finger_solid(answer.geometry, solid, tendon_hole_m)
    if files.plot is not None:
        from musclewire_design._finger.figures import plot_finger

        suffix = files.plot.suffix.removeprefix(".")
        figure = plot_finger(answer)
        write_whole(files.plot, lambda part: figure.savefig(part, format=suffix))


MM, MPA = 1e3, 1e-6


def finger_answer(answer: FingerStudyResult, files: PartFiles) -> FingerAnswer:
    """Return an answer under the keys of the interface."""
    from musclewire_design._answers import FingerAnswer

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
