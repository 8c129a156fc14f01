"""Commands about wires one can buy: simulate a drive, and the catalogue compared with the simulation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from musclewire.app import (
    LIST,
    OVERWRITE,
    SEED,
    SHUNT,
    WIRE,
    WIRE_LENGTH,
    FigureOptions,
    Result,
    in_si,
    own_help,
    progress_bar,
    require_recording_file,
    stops_between_samples,
    warn,
)
from musclewire.errors import CallerError
from musclewire.extras.supply._options import (
    AIR,
    CURRENT,
    DURATION,
    DUTY,
    DUTY_PERIOD,
    LOAD,
    OFF_AFTER,
    SPRING,
    STRESS,
    SUPPLY,
    TABLE,
)
from musclewire.extras.supply._text import (
    answer_text,
    comparison_answer,
    comparison_text,
    simulate_answer,
    table_answer,
    table_text,
    wires,
    wires_text,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.extras.supply._sizing import SupplyRequest, SupplySizing


@dataclass(frozen=True)
class DriveOptions:
    """How the wire is heated, and for how long."""

    supply: Annotated[str | None, SUPPLY] = None
    current: Annotated[str | None, CURRENT] = None
    off_after: Annotated[str, OFF_AFTER] = "1 s"
    duty: Annotated[str | None, DUTY] = None
    duty_period: Annotated[str, DUTY_PERIOD] = "1 s"
    duration: Annotated[str | None, DURATION] = None
    shunt: Annotated[str | None, SHUNT] = None


@dataclass(frozen=True)
class MountingOptions:
    """How long the wire is, what it pulls, and in which air."""

    wire_length: Annotated[str, WIRE_LENGTH] = "140 mm"
    load: Annotated[str | None, LOAD] = None
    stress: Annotated[str | None, STRESS] = None
    spring: Annotated[str | None, SPRING] = None
    ambient: Annotated[str, AIR] = "22 degC"


def request_of(wire: str, drive: DriveOptions, mounting: MountingOptions, seed: int) -> SupplyRequest:
    """Return the request that the options describe, in SI."""
    from musclewire.extras.supply._sizing import SupplyRequest

    return SupplyRequest(
        wire=wire,
        supply_v=in_si("--supply", drive.supply),
        current_a=in_si("--current", drive.current),
        on_s=in_si("--off-after", drive.off_after),
        duty=in_si("--duty", drive.duty),
        duty_period_s=in_si("--duty-period", drive.duty_period),
        duration_s=in_si("--duration", drive.duration),
        length_m=in_si("--wire-length", mounting.wire_length),
        load_n=in_si("--load", mounting.load),
        stress_pa=in_si("--stress", mounting.stress),
        spring_n_per_m=in_si("--spring", mounting.spring) or 0.0,
        shunt_ohm=in_si("--shunt", drive.shunt),
        ambient_k=in_si("--ambient", mounting.ambient),
        seed=seed,
    )


def simulate(
    drive: DriveOptions,
    mounting: MountingOptions,
    figure: FigureOptions,
    wire: Annotated[str, WIRE] = "flexinol-0.10-lt",
    output: Annotated[Path | None, own_help("--output", "Recording to write (.h5).")] = None,
    seed: Annotated[int, SEED] = 1,
    list_wires: Annotated[bool, LIST] = False,
    table: Annotated[bool, TABLE] = False,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Simulate a drive through a wire: which supply, shunt and current it needs."""
    if list_wires:
        found = wires()
        return Result(found, wires_text(found))
    if table:
        refuse_with_table(drive, mounting, output, figure.plot)
        return table_of_wires(mounting)
    from musclewire.extras.supply._sizing import plan_supply, size_supply

    request = request_of(wire, drive, mounting, seed)
    if output is not None:
        require_recording_file(output, overwrite)
    figure.check()
    with stops_between_samples(), progress_bar("Drive", plan_supply(request).duration_s) as on_sample:
        sizing = size_supply(request, path=output, overwrite=overwrite, on_sample=on_sample)
    if not sizing.numbers.melted:
        figure.draw(partial(drawn, sizing))
    warn(sizing.warnings)
    answer = simulate_answer(sizing, output)
    return Result(answer, answer_text(sizing, answer.catalogue), holds=not sizing.numbers.melted)


def drawn(answer: SupplySizing, *, style: str) -> Axes:
    """Return the drawn drive; loads what draws only now."""
    from musclewire.extras.supply._figure import drive_axes

    return drive_axes(answer, style=style)


def refuse_with_table(drive: DriveOptions, mounting: MountingOptions, output: Path | None, plot: Path | None) -> None:
    """Raise CallerError for options that a table of all wires has no use for."""
    given = {
        "--supply": drive.supply,
        "--current": drive.current,
        "--load": mounting.load,
        "--spring": mounting.spring,
        "--shunt": drive.shunt,
        "--duty": drive.duty,
        "--output": output,
        "--plot": plot,
    }
    for name, value in given.items():
        if value is not None:
            raise CallerError(f"{name} is for one wire: with --table give --wire-length, --stress and --ambient only")


def table_of_wires(mounting: MountingOptions) -> Result:
    """Return what every wire of the catalogue needs at a length."""
    from musclewire.extras.supply._catalogue_check import PULL_STRESS_PA
    from musclewire.extras.supply._wire_table import wire_table

    length_m = in_si("--wire-length", mounting.wire_length)
    stress_pa = PULL_STRESS_PA if mounting.stress is None else in_si("--stress", mounting.stress)
    ambient_k = in_si("--ambient", mounting.ambient)
    if not (length_m > 0.0 and stress_pa > 0.0 and 200.0 < ambient_k < 330.0):
        raise CallerError(
            f"--wire-length {length_m:g} m, --stress {1e-6 * stress_pa:g} MPa, --ambient {ambient_k - 273.15:g} degC: "
            "--table needs the first two above 0 and air of -73 to 57 degC"
        )
    rows = wire_table(length_m, stress_pa, ambient_k)
    answer = table_answer(rows, length_m, stress_pa, ambient_k)
    return Result(answer, table_text(rows, length_m, stress_pa, ambient_k))


def catalogue() -> Result:
    """Compare the Flexinol catalogue with the simulation: contraction after one second, and cooling times."""
    from musclewire.extras.supply._catalogue_check import compare_catalogue

    compared = compare_catalogue()
    answer = comparison_answer(compared)
    return Result(answer, comparison_text(compared, answer), holds=answer.ok)
