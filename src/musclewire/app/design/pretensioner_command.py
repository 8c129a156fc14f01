"""``musclewire design pretensioner``: from a wanted stiffness to a part to cut, or from a part to what it does."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app.design.pretensioner_text import made_json, made_text, materials_json, materials_text
from musclewire.app.files import require_figure_file, require_folder, save_figure
from musclewire.app.options import Json, quantity_option
from musclewire.app.output import emit_json, say, show
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.design.serpentine.analysis import Duty, Pretensioner
    from musclewire.design.serpentine.geometry import Envelope, SerpentineGeometry
    from musclewire.parameters.materials import Material

__all__ = ["pretensioner"]

# A number at the beginning of a text; what is left is its unit.
NUMBER = re.compile(r"^[+-]?[\d.]+([eE][+-]?\d+)?\s*")
FORMATS = (".svg", ".dxf")
# Lan and Fan 2010, section 4: the pretensioner's dimensions and the pretension of the finger's wire. The stroke, 3 % of
# a leg of 35 mm, is ours.
USUAL_MATERIAL, USUAL_PRETENSION, USUAL_ENVELOPE, USUAL_DEPTH = "pom", "0.71 N", "24.6x27.6x10 mm", "10 mm"
DIMENSIONS = ("--beams", "--half-length", "--pitch", "--thickness")


def pretensioner(
    stiffness: Annotated[
        str | None, typer.Option("--stiffness", help="Size a pretensioner of this stiffness, as '386.2 N/m'.")
    ] = None,
    pretension: Annotated[
        str | None, typer.Option("--pretension", help="Force it shall put on the wire; 0.71 N without it and --travel.")
    ] = None,
    stroke: Annotated[str, typer.Option("--stroke", help="What the wire then contracts by.")] = "1.05 mm",
    travel: Annotated[
        str | None, typer.Option("--travel", help="Whole travel of the connector; from pretension and stroke without.")
    ] = None,
    finger: Annotated[
        str | None, typer.Option("--finger-stiffness", help="Finger it works beside and must be softer than.")
    ] = None,
    material: Annotated[
        str | None, typer.Option("--material", help="Material by name, or its .toml file; pom without it.")
    ] = None,
    process: Annotated[
        str | None, typer.Option("--process", help="How it is made; the material's usual process without it.")
    ] = None,
    envelope: Annotated[
        str | None,
        typer.Option("--envelope", help="Room across the wire, along it, out of plane; the paper's without it."),
    ] = None,
    file: Annotated[str | None, typer.Option("--file", help="Take all dimensions from a pretensioner's file.")] = None,
    beams: Annotated[int | None, typer.Option("--beams", help="Take dimensions as given: number of beams.")] = None,
    half_length: Annotated[str | None, typer.Option("--half-length", help="Half of a beam's length, a.")] = None,
    pitch: Annotated[str | None, typer.Option("--pitch", help="Between the middles of beams, p.")] = None,
    thickness: Annotated[str | None, typer.Option("--thickness", help="Thickness of beams in the plane, t.")] = None,
    depth: Annotated[str | None, typer.Option("--depth", help="Depth out of plane, b; 10 mm, or all the room.")] = None,
    corner: Annotated[
        str | None, typer.Option("--corner-radius", help="Inner radius of corners; a quarter of the thickness without.")
    ] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Pretensioner file to write (.toml).")] = None,
    drawing: Annotated[
        list[Path] | None, typer.Option("--drawing", help="Drawing to cut, 1:1 (.svg, .dxf). Repeatable.")
    ] = None,
    plot: Annotated[Path | None, typer.Option("--plot", help="Figure to write (.svg, .png, .pdf).")] = None,
    list_materials: Annotated[bool, typer.Option("--list", help="Show all materials and end.")] = False,
    json: Json = False,
) -> None:
    """Size a serpentine pretensioner, or tell what one of given dimensions does."""
    if list_materials:
        emit_json(materials_json()) if json else show(materials_text())
        return
    given = {"--beams": beams, "--half-length": half_length, "--pitch": pitch, "--thickness": thickness}
    require_one_way(stiffness, file, given, corner)
    if file is not None and depth is not None:
        raise CallerError("--depth and --file contradict each other: the file has a depth")
    require_files(output, drawing, plot)
    from musclewire.design.serpentine.analysis import analyse

    duty = duty_from(pretension, stroke, travel, finger)
    room: Envelope | None
    if stiffness is not None:
        name = material or USUAL_MATERIAL
        within = room_from(USUAL_ENVELOPE if envelope is None else envelope, depth)
        made, room = sized(stiffness, duty, name, process, within), within
    else:
        # What is given as it is need not fit into anything, unless told to.
        room = None if envelope is None else room_from(envelope, None)
        name, process, geometry = file_or_dimensions(file, given, depth, corner, material, process)
        made = analyse(geometry, material_named(name), process, duty, room)
    write_files(made, name, output, drawing, plot)
    if json:
        emit_json(made_json(made, name, room))
    else:
        show(made_text(made, room))
    if not made.holds:
        for check in made.checks:
            if not check.ok:
                say(f"warning: it does not hold: {check.name}")
        raise typer.Exit(1)


def require_one_way(
    stiffness: str | None, file: str | None, given: dict[str, int | str | None], corner: str | None
) -> None:
    """Raise CallerError unless the question is put in exactly one way."""
    dimensions = [name for name, value in given.items() if value is not None]
    ways = [name for name, used in (("--stiffness", stiffness), ("--file", file)) if used is not None]
    if len(ways) + bool(dimensions) > 1:
        raise CallerError(f"{' and '.join([*ways, *dimensions[:1]])} contradict each other: give one of them")
    if not ways and not dimensions:
        raise CallerError(f"give --stiffness to size a pretensioner, {', '.join(DIMENSIONS)} to compute one, or --file")
    if dimensions and len(dimensions) < len(given):
        missing = [name for name, value in given.items() if value is None]
        raise CallerError(f"{dimensions[0]} wants {' and '.join(missing)} too")
    if corner is not None and not dimensions:
        raise CallerError(f"--corner-radius goes with dimensions as given: {', '.join(DIMENSIONS)}")


def require_files(output: Path | None, drawing: list[Path] | None, plot: Path | None) -> None:
    """Raise CallerError for files of a kind that is not written here, or without a folder."""
    if output is not None:
        if output.suffix != ".toml":
            raise CallerError(f"{output}: a pretensioner is a .toml file")
        require_folder(output)
    for path in drawing or []:
        if path.suffix not in FORMATS:
            raise CallerError(f"{path}: a drawing is one of {', '.join(FORMATS)}")
        require_folder(path)
    require_figure_file(plot)


def duty_from(pretension: str | None, stroke: str, travel: str | None, finger: str | None) -> Duty:
    """Return what the pretensioner is for."""
    from musclewire.design.serpentine.analysis import Duty

    if pretension is None and travel is None:
        pretension = USUAL_PRETENSION
    return Duty(
        pretension_n=quantity_option(pretension, "N", "--pretension"),
        stroke_m=quantity_option(stroke, "m", "--stroke") or 0.0,
        travel_m=quantity_option(travel, "m", "--travel"),
        finger_stiffness_n_per_m=quantity_option(finger, "N/m", "--finger-stiffness"),
    )


def room_from(envelope: str, depth: str | None) -> Envelope:
    """Return the room there is, from '24.6x27.6x10 mm'; a depth that is given takes the place of the third size."""
    from musclewire.design.serpentine.geometry import Envelope
    from musclewire.signals.units import parse_quantity

    parts = [part.strip() for part in re.split(r"[x×]", envelope)]
    unit = re.sub(NUMBER, "", parts[-1])
    if len(parts) != 3 or not unit:
        raise CallerError(f"'{envelope}' is no envelope: write three sizes and a unit, as '24.6x27.6x10 mm'")
    across, along, deep = (
        parse_quantity(part if re.sub(NUMBER, "", part) else f"{part} {unit}", "m") for part in parts
    )
    asked = quantity_option(depth, "m", "--depth")
    if asked is not None and asked > deep:
        raise CallerError(
            f"a depth of {1e3 * asked:g} mm does not fit: it is {1e3 * (asked - deep):g} mm more than the "
            f"{1e3 * deep:g} mm of the envelope"
        )
    return Envelope(across, along, deep if asked is None else asked)


def material_named(name: str) -> Material:
    """Return a material by name or file."""
    from musclewire.parameters.materials import load_material

    return load_material(name)


def sized(stiffness: str, duty: Duty, material: str, process: str | None, room: Envelope) -> Pretensioner:
    """Return the pretensioner of a wanted stiffness."""
    from musclewire.design.serpentine.sizing import PretensionerRequest, design_pretensioner

    wanted = quantity_option(stiffness, "N/m", "--stiffness") or 0.0
    return design_pretensioner(PretensionerRequest(wanted, duty, material_named(material), room, process))


def file_or_dimensions(
    file: str | None,
    given: dict[str, int | str | None],
    depth: str | None,
    corner: str | None,
    material: str | None,
    process: str | None,
) -> tuple[str, str | None, SerpentineGeometry]:
    """Return material, process and dimensions from a file, or from the options."""
    from musclewire.design.serpentine.geometry import SerpentineGeometry
    from musclewire.design.serpentine.pretensioner_file_text import geometry_of
    from musclewire.parameters.pretensioner_file import read_pretensioner

    if file is not None:
        saved = read_pretensioner(file)
        # Another material is another process, unless one is named.
        usual = saved.process if material is None else None
        return material or saved.material, process or usual, geometry_of(saved)
    half, pitch, thick = (
        quantity_option(str(given[name]), "m", name) or 0.0 for name in ("--half-length", "--pitch", "--thickness")
    )
    deep = quantity_option(USUAL_DEPTH if depth is None else depth, "m", "--depth") or 0.0
    geometry = SerpentineGeometry.of(int(given["--beams"] or 0), half, pitch, thick, deep)
    if corner is not None:
        geometry = geometry.with_(corner_radius_m=quantity_option(corner, "m", "--corner-radius") or 0.0)
    return material or USUAL_MATERIAL, process, geometry


def write_files(
    made: Pretensioner, material: str, output: Path | None, drawing: list[Path] | None, plot: Path | None
) -> None:
    """Write what was asked for, each file whole or not at all."""
    from musclewire.design.drawing import write_drawing
    from musclewire.design.serpentine.figures import draw_pretensioner
    from musclewire.design.serpentine.outline import serpentine_drawing
    from musclewire.design.serpentine.pretensioner_file_text import pretensioner_text
    from musclewire.signals.whole_files import write_whole

    if output is not None:
        text = pretensioner_text(made, material)
        write_whole(output, lambda part: (part.write_text(text, encoding="utf-8"), None)[1])
    if drawing:
        note = (
            f"{1e3 * made.geometry.depth_m:g} mm deep, {made.material.name}, {made.process}: "
            f"{made.stiffness_n_per_m:.1f} N/m along the wire"
        )
        for path in drawing:
            write_drawing(serpentine_drawing(made.geometry, "serpentine pretensioner", note), path)
    if plot is not None:
        save_figure(draw_pretensioner(made), plot)
