"""``musclewire design pretensioner``: from a wanted stiffness to a part to cut, or from a part to what it does."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from musclewire.app import FILE, LIST, Result, in_si, save_figure, warn
from musclewire.errors import CallerError
from musclewire_design._commands.check_text import check_lines
from musclewire_design._commands.part_options import OPTIONS_FILE, PartFiles
from musclewire_design._options import (
    BEAMS,
    CORNER_RADIUS,
    DEPTH,
    ENVELOPE,
    FINGER_STIFFNESS,
    HALF_LENGTH,
    MATERIAL,
    PITCH,
    PRETENSION,
    PROCESS,
    STIFFNESS,
    STROKE,
    THICKNESS,
    TRAVEL,
)

if TYPE_CHECKING:
    from musclewire.parameters import Material
    from musclewire_design._answers import MaterialsAnswer, PretensionerAnswer
    from musclewire_design._serpentine.analysis import PretensionerDesign, PretensionerDuty
    from musclewire_design._serpentine.geometry import AvailableRoom, SerpentineGeometry


# A number at the beginning of a text; what is left is its unit.
NUMBER = re.compile(r"^[+-]?[\d.]+([eE][+-]?\d+)?\s*")
# Lan and Fan 2010, section 4: the pretensioner's dimensions and the pretension of the finger's wire. The stroke, 3 % of
# a leg of 35 mm, is ours.
USUAL_MATERIAL, USUAL_PRETENSION, USUAL_ENVELOPE, USUAL_DEPTH = "pom", "0.71 N", "24.6x27.6x10 mm", "10 mm"
DIMENSIONS = ("--beams", "--half-length", "--pitch", "--thickness")


@dataclass(frozen=True)
class DimensionOptions:
    """Dimensions as given, instead of those that are computed from a stiffness."""

    beams: Annotated[int | None, BEAMS] = None
    half_length: Annotated[str | None, HALF_LENGTH] = None
    pitch: Annotated[str | None, PITCH] = None
    thickness: Annotated[str | None, THICKNESS] = None
    corner_radius: Annotated[str | None, CORNER_RADIUS] = None

    def named(self) -> dict[str, int | str | None]:
        """Return what must be given together, by option."""
        return dict(zip(DIMENSIONS, (self.beams, self.half_length, self.pitch, self.thickness), strict=True))

    def geometry(self, depth: str | None) -> SerpentineGeometry:
        """Return the geometry of these dimensions."""
        from musclewire_design._serpentine.geometry import SerpentineGeometry

        geometry = SerpentineGeometry.with_corner_fraction(
            self.beams or 0,
            in_si("--half-length", self.half_length) or 0.0,
            in_si("--pitch", self.pitch) or 0.0,
            in_si("--thickness", self.thickness) or 0.0,
            in_si("--depth", USUAL_DEPTH if depth is None else depth),
        )
        if self.corner_radius is not None:
            geometry = geometry.with_(corner_radius_m=in_si("--corner-radius", self.corner_radius))
        return geometry


@dataclass(frozen=True)
class DutyOptions:
    """What the pretensioner is for."""

    pretension: Annotated[str | None, PRETENSION] = None
    stroke: Annotated[str, STROKE] = "1.05 mm"
    travel: Annotated[str | None, TRAVEL] = None
    finger_stiffness: Annotated[str | None, FINGER_STIFFNESS] = None

    def duty(self) -> PretensionerDuty:
        """Return it in SI."""
        from musclewire_design._serpentine.analysis import PretensionerDuty

        usual = USUAL_PRETENSION if self.travel is None else None
        return PretensionerDuty(
            pretension_n=in_si("--pretension", self.pretension or usual),
            stroke_m=in_si("--stroke", self.stroke),
            travel_m=in_si("--travel", self.travel),
            finger_stiffness_n_per_m=in_si("--finger-stiffness", self.finger_stiffness),
        )


@dataclass(frozen=True)
class MakingOptions:
    """What the pretensioner is made of, how, and in which room."""

    material: Annotated[str | None, MATERIAL] = None
    process: Annotated[str | None, PROCESS] = None
    envelope: Annotated[str | None, ENVELOPE] = None
    depth: Annotated[str | None, DEPTH] = None


def pretensioner(
    dimensions: DimensionOptions,
    duty: DutyOptions,
    making: MakingOptions,
    files: PartFiles,
    options_file: Annotated[Path | None, OPTIONS_FILE] = None,
    stiffness: Annotated[str | None, STIFFNESS] = None,
    file: Annotated[str | None, FILE] = None,
    list_materials: Annotated[bool, LIST] = False,
) -> Result:
    """Size a serpentine pretensioner, or compute what one of given dimensions does."""
    del options_file  # its values have become those of the options
    if list_materials:
        return Result(materials_answer(), materials_text())
    files.require("pretensioner")
    require_one_way(stiffness, file, dimensions)
    if file is not None and making.depth is not None:
        raise CallerError("--depth and --file contradict each other: the file has a depth, leave --depth out")
    room: AvailableRoom | None
    if stiffness is not None:
        made, name, room = sized(stiffness, duty.duty(), making)
    else:
        made, name, room = computed(file, dimensions, duty.duty(), making)
    write_files(made, name, files)
    warn(f"it does not hold: {check.name}" for check in made.checks if not check.ok)
    return Result(made_answer(made, name, room), made_text(made, room), made.holds)


def require_one_way(stiffness: str | None, file: str | None, dimensions: DimensionOptions) -> None:
    """Raise CallerError unless the question is put in exactly one way."""
    named = dimensions.named()
    given = [name for name, value in named.items() if value is not None]
    ways = [name for name, used in (("--stiffness", stiffness), ("--file", file)) if used is not None]
    if len(ways) + bool(given) > 1:
        raise CallerError(f"{' and '.join([*ways, *given[:1]])} contradict each other: give one of them")
    if not ways and not given:
        raise CallerError(f"give --stiffness to size a pretensioner, {', '.join(DIMENSIONS)} to compute one, or --file")
    if given and len(given) < len(named):
        missing = [name for name, value in named.items() if value is None]
        raise CallerError(f"{given[0]} requires {' and '.join(missing)}: give them too")
    if dimensions.corner_radius is not None and not given:
        raise CallerError(
            f"--corner-radius has an effect only with given dimensions: leave it out, or give {', '.join(DIMENSIONS)}"
        )


def room_from(envelope: str, depth: str | None) -> AvailableRoom:
    """Return the room there is, from '24.6x27.6x10 mm'; a depth that is given takes the place of the third size."""
    from musclewire.signals import parse_quantity
    from musclewire_design._serpentine.geometry import AvailableRoom

    parts = [part.strip() for part in re.split(r"[x×]", envelope)]
    unit = re.sub(NUMBER, "", parts[-1])
    if len(parts) != 3 or not unit:
        raise CallerError(f"'{envelope}' is no envelope: write three sizes and a unit, as '24.6x27.6x10 mm'")
    across, along, deep = (
        parse_quantity(part if re.sub(NUMBER, "", part) else f"{part} {unit}", "m") for part in parts
    )
    asked = in_si("--depth", depth)
    if asked is not None and asked > deep:
        raise CallerError(
            f"a depth of {1e3 * asked:g} mm does not fit: it is {1e3 * (asked - deep):g} mm more than the "
            f"{1e3 * deep:g} mm of the envelope; give less, or a deeper envelope"
        )
    return AvailableRoom(across, along, deep if asked is None else asked)


def material_named(name: str) -> Material:
    """Return a material by name or file."""
    from musclewire.parameters import load_material

    return load_material(name)


def sized(
    stiffness: str, duty: PretensionerDuty, making: MakingOptions
) -> tuple[PretensionerDesign, str, AvailableRoom]:
    """Return the pretensioner of a wanted stiffness, the name of its material, and the room for it."""
    from musclewire_design._serpentine.sizing import PretensionerRequest, design_pretensioner

    name = making.material or USUAL_MATERIAL
    room = room_from(USUAL_ENVELOPE if making.envelope is None else making.envelope, making.depth)
    wanted = in_si("--stiffness", stiffness)
    made = design_pretensioner(PretensionerRequest(wanted, duty, material_named(name), room, making.process))
    return made, name, room


def computed(
    file: str | None, dimensions: DimensionOptions, duty: PretensionerDuty, making: MakingOptions
) -> tuple[PretensionerDesign, str, AvailableRoom | None]:
    """Return the pretensioner of a file or of given dimensions, the name of its material, and the room for it."""
    from musclewire.parameters import read_pretensioner
    from musclewire_design._serpentine.analysis import analyse
    from musclewire_design._serpentine.pretensioner_file_text import geometry_of

    # Given dimensions need not fit into anything, unless an envelope is given too.
    room = None if making.envelope is None else room_from(making.envelope, None)
    name, process = making.material or USUAL_MATERIAL, making.process
    if file is None:
        geometry = dimensions.geometry(making.depth)
    else:
        saved = read_pretensioner(file)
        # Another material is another process, unless one is named.
        name, process = making.material or saved.material, process or (None if making.material else saved.process)
        geometry = geometry_of(saved)
    return analyse(geometry, material_named(name), process, duty, room), name, room


def write_files(made: PretensionerDesign, material: str, files: PartFiles) -> None:
    """Write what was requested, each file whole or not at all."""
    from musclewire.signals import write_text_whole
    from musclewire_design._drawing import write_drawing
    from musclewire_design._serpentine.figures import draw_pretensioner
    from musclewire_design._serpentine.outline import serpentine_drawing
    from musclewire_design._serpentine.pretensioner_file_text import pretensioner_text

    if files.output is not None:
        write_text_whole(files.output, pretensioner_text(made, material))
    if files.drawings:
        note = (
            f"{1e3 * made.geometry.depth_m:g} mm deep, {made.material.name}, {made.process}: "
            f"{made.stiffness_n_per_m:.1f} N/m along the wire"
        )
        for path in files.drawings:
            write_drawing(serpentine_drawing(made.geometry, "serpentine pretensioner", note), path)
    for path in files.solids:
        from musclewire_design._solid import Solid, write_solid

        drawing = serpentine_drawing(made.geometry, "serpentine pretensioner")
        write_solid(Solid(drawing, made.geometry.depth_m), path)
    if files.plot is not None:
        save_figure(draw_pretensioner(made), files.plot)


MM, MPA = 1e3, 1e-6


def made_answer(made: PretensionerDesign, material: str, room: AvailableRoom | None) -> PretensionerAnswer:
    """Return a pretensioner under the keys of the interface."""
    from musclewire_design._answers import PretensionerAnswer

    return PretensionerAnswer.read_from(
        made,
        stiffness_guided_n_per_m=made.guided.stiffness_n_per_m,
        stress_max_pa=made.stress_pa,
        stress_allowable_pa=made.material.allowable_stress_pa.value,
        stress_yield_pa=made.material.yield_stress_pa.value,
        pretension_n=made.duty.pretension_n,
        safe_travel_m=made.curve.safe_travel_m,
        finger_share=finger_share(made),
        envelope_m=room,
        material=material,
    )


def finger_share(made: PretensionerDesign) -> float | None:
    """Return the fraction of the contraction force that the finger gets, k_f/(k_p + k_f); None without a finger."""
    finger = made.duty.finger_stiffness_n_per_m
    return None if finger is None else finger / (finger + made.stiffness_n_per_m)


def made_text(made: PretensionerDesign, room: AvailableRoom | None) -> str:
    """Return a pretensioner as lines for people."""
    g, curve = made.geometry, made.curve
    sizes = " x ".join(f"{MM * size:.2f}" for size in (g.across_m, g.along_m, g.depth_m))
    rooms = "" if room is None else f"; there are {' x '.join(f'{MM * size:g}' for size in room)} mm"
    lines = [
        f"serpentine pretensioner of {made.material.name} ({made.process})",
        f"  dimensions  {g.beams} beams, half length {MM * g.half_length_m:.2f} mm, pitch {MM * g.pitch_m:.2f} mm, "
        f"{MM * g.thickness_m:.2f} mm thick, {MM * g.depth_m:.2f} mm deep, corners of {MM * g.corner_radius_m:.2f} mm",
        f"  size        {sizes} mm across the wire, along it, out of plane{rooms}",
        f"  stiffness   {made.stiffness_n_per_m:.1f} N/m; {made.guided.stiffness_n_per_m:.1f} N/m if the connector can "
        "neither turn nor move aside",
    ]
    lines += duty_lines(made)
    lines.append(
        f"  safe        to {MM * curve.safe_travel_m:.2f} mm of travel, {curve.force_at(curve.safe_travel_m):.2f} N"
    )
    fraction = finger_share(made)
    if fraction is not None:
        lines.append(
            f"  finger      {100 * fraction:.0f} % of the contraction force goes to a finger of "
            f"{made.duty.finger_stiffness_n_per_m:g} N/m"
        )
    return "\n".join([*lines, "", *check_lines(made.checks)])


def duty_lines(made: PretensionerDesign) -> list[str]:
    """Return the lines of travel and stress."""
    if made.travel_m is None or made.stress_pa is None:
        return []
    duty, material = made.duty, made.material
    parts = ""
    if duty.travel_m is None and duty.pretension_n is not None:
        parts = (
            f": {MM * (made.travel_m - duty.stroke_m):.2f} mm for {duty.pretension_n:g} N of pretension, "
            f"{MM * duty.stroke_m:.2f} mm with the wire"
        )
    return [
        f"  travel      {MM * made.travel_m:.2f} mm{parts}",
        f"  stress      {MPA * made.stress_pa:.1f} MPa there, a strain of "
        f"{100 * made.stress_pa / material.youngs_modulus_pa.value:.2g} %; "
        f"{MPA * material.allowable_stress_pa.value:g} MPa are allowed for long, "
        f"{MPA * material.yield_stress_pa.value:g} MPa are the yield stress",
    ]


def materials_answer() -> MaterialsAnswer:
    """Return all included materials."""
    from musclewire.parameters import load_material, material_names
    from musclewire_design._answers import IncludedMaterial, MaterialsAnswer

    found = []
    for name in material_names():
        material = load_material(name)
        thinnest_m = {process: thickness.value for process, thickness in material.minimum_thickness_m.items()}
        found.append(IncludedMaterial(name=name, minimum_thickness_m=thinnest_m, **material.values()))
    return MaterialsAnswer(materials=tuple(found))


def materials_text() -> str:
    """Return all included materials as a table."""
    from musclewire.parameters import load_material, material_names

    lines = [f"{'material':<16}{'modulus':>10}{'yield':>10}{'allowed':>10}   thinnest by process"]
    for name in material_names():
        material = load_material(name)
        processes = ", ".join(f"{key} {MM * it.value:g} mm" for key, it in material.minimum_thickness_m.items())
        lines.append(
            f"{name:<16}{1e-9 * material.youngs_modulus_pa.value:>6.4g} GPa"
            f"{MPA * material.yield_stress_pa.value:>6.4g} MPa{MPA * material.allowable_stress_pa.value:>6.4g} MPa"
            f"   {processes}"
        )
    return "\n".join(lines)
