"""``musclewire design finger``: from what a finger shall do to its dimensions, or from dimensions to what it does."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app.design.finger_text import answer_json, answer_text
from musclewire.app.files import require_figure_file, require_folder
from musclewire.app.options import Json, quantity_option
from musclewire.app.output import emit_json, say, show
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.design.finger.finger_study import FingerStudyResult, WireToPull
    from musclewire.design.finger.geometry import FingerGeometry
    from musclewire.design.finger.sizing import FingerRequest
    from musclewire.design.finger.statics import Foam
    from musclewire.parameters.materials import Material

__all__ = ["finger"]


def finger(
    context: typer.Context,
    stiffness: Annotated[
        str | None, typer.Option("--stiffness", help="Size a finger of this stiffness along the tendon, '1084.4 N/m'.")
    ] = None,
    file: Annotated[
        str | None, typer.Option("--finger", help="Take the dimensions of a finger by name, or of its .toml file.")
    ] = None,
    thickness: Annotated[
        str | None, typer.Option("--thickness", help="Take dimensions as given: thickness of the beam.")
    ] = None,
    offset: Annotated[
        str | None, typer.Option("--offset", help="With --thickness: the tendon from the beam's middle.")
    ] = None,
    depth: Annotated[
        str, typer.Option("--depth", help="Depth of the beam: wished for with --stiffness, else as given.")
    ] = "5 mm",
    most_depth: Annotated[str, typer.Option("--most-depth", help="Most depth there is room for.")] = "10 mm",
    length: Annotated[str, typer.Option("--length", help="Overall length along the beam, plate included.")] = "10 mm",
    plate: Annotated[str, typer.Option("--plate", help="Length of the extension plate.")] = "5 mm",
    columns: Annotated[int, typer.Option("--columns", help="Columns that guide the tendon.")] = 4,
    column_width: Annotated[str, typer.Option("--column-width", help="Width of a column.")] = "0.3 mm",
    inward: Annotated[
        float,
        typer.Option("--inward", help="Degrees by which the unloaded segments are curved inward in all.", min=0.0),
    ] = 8.0,
    endpoint: Annotated[str, typer.Option("--endpoint", help="How far the endpoint shall move.")] = "6 mm",
    travel: Annotated[str, typer.Option("--travel", help="Travel of the tendon there is at most.")] = "1.05 mm",
    material: Annotated[str, typer.Option("--material", help="Material by name, or its .toml file.")] = "pom",
    process: Annotated[
        str | None, typer.Option("--process", help="Beam no thinner than this process makes it; 0.1 mm without it.")
    ] = None,
    friction: Annotated[
        float, typer.Option("--friction", help="Coefficient of friction between tendon and holes.", min=0.0)
    ] = 0.15,
    foam: Annotated[
        str | None, typer.Option("--foam", help="Stiffness of an object in the endpoint's way, as '50 N/m'.")
    ] = None,
    clearance: Annotated[str, typer.Option("--clearance", help="How far the endpoint is from it.")] = "4 mm",
    wire: Annotated[str | None, typer.Option("--wire", help="Check that this wire gives stroke and force.")] = None,
    wire_length: Annotated[str, typer.Option("--wire-length", help="Both legs of the V together.")] = "7 cm",
    pretension: Annotated[str, typer.Option("--pretension", help="Pretension of the wire, both legs.")] = "0.71 N",
    pretensioner: Annotated[
        str, typer.Option("--pretensioner", help="Stiffness of the pretensioner beside the finger, or its file.")
    ] = "386.2 N/m",
    compare: Annotated[
        bool, typer.Option("--compare", help="Compare distributed with concentrated actuation.")
    ] = False,
    refined: Annotated[
        int, typer.Option("--refined", help="How many times finer the finite elements shall be.", min=1, max=4)
    ] = 1,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Finger file to write (.toml).")] = None,
    drawing: Annotated[
        list[Path] | None, typer.Option("--drawing", help="Drawing to cut, 1:1 (.svg, .dxf). Repeatable.")
    ] = None,
    plot: Annotated[Path | None, typer.Option("--plot", help="Figure to write (.svg, .png, .pdf).")] = None,
    json: Json = False,
) -> None:
    """Size a tendon-driven flexible finger, or tell what one of given dimensions does."""
    from musclewire.design.finger.finger_study import FingerStudy, study_finger
    from musclewire.parameters.materials import load_material

    require_one_way({"--stiffness": stiffness, "--finger": file, "--thickness": thickness}, offset)
    require_effect(context, {"--stiffness": stiffness, "--finger": file, "--wire": wire, "--foam": foam})
    drawings = drawing or []
    require_files(output, drawings, plot)
    metal = load_material(material)
    lengths = {
        "overall_length_m": metres(length, "--length"),
        "plate_length_m": metres(plate, "--plate"),
        "column_width_m": metres(column_width, "--column-width"),
        "inward_angle_rad": math.radians(inward),
    }
    request = geometry = None
    if stiffness is not None:
        least = metal.minimum_thickness_by(process) if process else LEAST_THICKNESS_M
        wanted = (
            quantity_option(stiffness, "N/m", "--stiffness") or 0.0,
            metres(endpoint, "--endpoint"),
            metres(travel, "--travel"),
        )
        request = requested(
            wanted, lengths, columns, (metres(depth, "--depth"), metres(most_depth, "--most-depth"), least)
        )
    elif file is not None:
        geometry = of_file(file)
        require_material_of(geometry, file, metal)
    else:
        section = (metres(thickness, "--thickness"), metres(depth, "--depth"), metres(offset, "--offset"))
        geometry = given(section, lengths, columns, metal.youngs_modulus_pa.value)
        if process is not None:
            require_made(geometry, process, metal.minimum_thickness_by(process))
    answer = study_finger(
        FingerStudy(
            material=metal,
            endpoint_m=metres(endpoint, "--endpoint"),
            travel_m=metres(travel, "--travel"),
            request=request,
            geometry=geometry,
            friction=friction,
            foam=None if foam is None else foam_of(foam, clearance),
            wire=None if wire is None else wire_of(wire, wire_length, pretension, pretensioner),
            compare=compare,
            refined=refined,
        )
    )
    write_files(answer, output, drawings, plot)
    if json:
        emit_json(answer_json(answer, output, drawings))
    else:
        show(answer_text(answer))
        for warning in [*answer.warnings, *(f"it does not hold: {one.name}" for one in answer.checks if not one.ok)]:
            say(f"warning: {warning}")
    if not all(check.ok for check in answer.checks):
        raise typer.Exit(1)


# Batches and sheets of one material differ by less.
MODULUS_MARGIN = 0.3
# Film and thin strip are sold from about here.
LEAST_THICKNESS_M = 0.1e-3
WAYS = "--stiffness '1084.4 N/m' to size one, --finger NAME for one that is there, or --thickness and --offset"


def metres(text: str | None, option: str) -> float:
    """Return a length option in metres."""
    return quantity_option(text, "m", option) or 0.0


def require_one_way(ways: dict[str, str | None], offset: str | None) -> None:
    """Raise CallerError where not exactly one of the ways to say which finger is meant was taken."""
    taken = [name for name, value in ways.items() if value is not None]
    if not taken:
        raise CallerError(f"say which finger: {WAYS}")
    if len(taken) > 1:
        raise CallerError(f"{' and '.join(taken)} exclude each other: give one of them")
    if (offset is None) != (ways["--thickness"] is None):
        raise CallerError("--thickness and --offset belong together: dimensions are given with both of them")


# What an option needs beside it, or must not have, to change anything.
NEEDS = {"clearance": "--foam", "wire_length": "--wire", "pretension": "--wire", "pretensioner": "--wire"}
OF_A_FILE = ("depth", "length", "plate", "columns", "column_width", "inward", "process")


def require_effect(context: typer.Context, others: dict[str, str | None]) -> None:
    """Raise CallerError for an option that was given and would change nothing beside the others."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    for name in (name for name, source in sources.items() if source is not None and source.name == "COMMANDLINE"):
        option = f"--{name.replace('_', '-')}"
        if name in NEEDS and others[NEEDS[name]] is None:
            raise CallerError(f"{option} goes with {NEEDS[name]}: give that too")
        if name in OF_A_FILE and others["--finger"] is not None:
            raise CallerError(f"{option} and --finger exclude each other: a finger's file has all dimensions")
        if name == "most_depth" and others["--stiffness"] is None:
            raise CallerError(f"{option} goes with --stiffness: dimensions are as given")


def require_files(output: Path | None, drawings: list[Path], plot: Path | None) -> None:
    """Raise CallerError for files that are not written here, before any work is done."""
    if output is not None:
        if output.suffix != ".toml":
            raise CallerError(f"{output}: a finger is a .toml file")
        require_folder(output)
    for drawing in drawings:
        if drawing.suffix not in (".svg", ".dxf"):
            raise CallerError(f"{drawing}: a drawing is one of .svg, .dxf")
        require_folder(drawing)
    require_figure_file(plot)


def requested(
    wanted: tuple[float, float, float],
    lengths: dict[str, float],
    columns: int,
    section: tuple[float, float, float],
) -> FingerRequest:
    """Return the request for a finger: stiffness, endpoint and travel wanted, and the room for its section."""
    from musclewire.design.finger.sizing import FingerRequest

    return FingerRequest(
        stiffness_n_per_m=wanted[0],
        endpoint_m=wanted[1],
        travel_m=wanted[2],
        columns=columns,
        depth_m=section[0],
        most_depth_m=section[1],
        least_thickness_m=section[2],
        **lengths,
    )


def given(
    section: tuple[float, float, float], lengths: dict[str, float], columns: int, youngs_modulus_pa: float
) -> FingerGeometry:
    """Return the geometry of given thickness, depth and offset."""
    from musclewire.design.finger.sizing import geometry_of_section

    thickness, depth, offset = section
    return geometry_of_section(thickness, depth, offset, lengths, columns, youngs_modulus_pa)


def require_material_of(geometry: FingerGeometry, file: str, material: Material) -> None:
    """Raise CallerError where a finger file is of a material much stiffer or softer than the one to judge it by."""
    own, other = geometry.youngs_modulus_pa, material.youngs_modulus_pa.value
    if abs(own / other - 1.0) > MODULUS_MARGIN:
        raise CallerError(
            f"finger {file} is of {1e-9 * own:g} GPa, and {material.name} has {1e-9 * other:g} GPa: name its own "
            "--material, or compute another by --thickness and --offset"
        )


def require_made(geometry: FingerGeometry, process: str, least_m: float) -> None:
    """Raise CallerError for a beam thinner than a process makes it."""
    if geometry.beam_thickness_m < least_m:
        short = 100 * (1 - geometry.beam_thickness_m / least_m)
        raise CallerError(
            f"a beam of {1e3 * geometry.beam_thickness_m:g} mm is {short:.0f} % thinner than the {1e3 * least_m:g} mm "
            f"that {process} makes: a thicker beam or another process"
        )


def of_file(name: str) -> FingerGeometry:
    """Return the geometry of a finger by name or file."""
    from musclewire.design.finger.finger_file_text import geometry_of_file
    from musclewire.parameters.finger_file import load_finger

    return geometry_of_file(load_finger(name))


def foam_of(stiffness: str, clearance: str) -> Foam:
    """Return the object in the endpoint's way."""
    from musclewire.design.finger.statics import Foam

    return Foam(metres(clearance, "--clearance"), quantity_option(stiffness, "N/m", "--foam") or 0.0)


def wire_of(name: str, length: str, pretension: str, pretensioner: str) -> WireToPull:
    """Return the question about a wire."""
    from musclewire.design.finger.finger_study import WireToPull
    from musclewire.parameters.pretensioner_file import read_pretensioner

    if pretensioner.endswith(".toml"):
        stiffness = read_pretensioner(pretensioner).stiffness_n_per_m
    else:
        stiffness = quantity_option(pretensioner, "N/m", "--pretensioner") or 0.0
    return WireToPull(
        name, metres(length, "--wire-length"), quantity_option(pretension, "N", "--pretension") or 0.0, stiffness
    )


def write_text(path: Path, text: str) -> None:
    """Write a text file."""
    path.write_text(text, "utf-8")


def write_files(answer: FingerStudyResult, output: Path | None, drawings: list[Path], plot: Path | None) -> None:
    """Write what was asked for, each file whole or not at all."""
    from musclewire.signals.whole_files import write_whole

    if output is not None:
        from musclewire.design.finger.finger_file_text import finger_study_file_text

        text = finger_study_file_text(output.stem, answer)
        write_whole(output, lambda part: write_text(part, text))
    for drawing in drawings:
        from musclewire.design.finger.drawing import write_finger_drawing

        write_finger_drawing(answer.geometry, drawing)
    if plot is not None:
        from musclewire.design.finger.figures import plot_finger

        figure = plot_finger(answer)
        write_whole(plot, lambda part: figure.savefig(part, format=plot.suffix.removeprefix(".")))
