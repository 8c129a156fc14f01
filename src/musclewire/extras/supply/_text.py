"""How a simulated drive, list and table of wires and the catalogue's comparison read: as text, and as keys for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from musclewire.app import table

if TYPE_CHECKING:
    from musclewire.extras.supply._answers import (
        CatalogueAnswer,
        CatalogueSide,
        SimulateAnswer,
        WiresAnswer,
        WireTableAnswer,
    )
    from musclewire.extras.supply._catalogue_check import CatalogueComparison, JudgedValue
    from musclewire.extras.supply._sizing import SupplyPlan, SupplySizing
    from musclewire.extras.supply._wire_table import WireRow
    from musclewire.parameters import CatalogueCell

ZERO_DEGC_K = 273.15
# What a simulation that went beyond the melting point has to say of the drive: nothing.
NONE_OF_A_MOLTEN_WIRE = (
    "contraction_pct",
    "largest_contraction_pct",
    "final_contraction_pct",
    "last_period_pct",
    "contraction_m",
    "contraction_share_pct",
    "contracted_s",
    "cooling_s",
    "true_peak_temperature_degc",
    "settled_temperature_degc",
    "current_mean_a",
    "drive_voltage_peak_v",
    "power_peak_w",
    "energy_j",
)
MARKS = {"corroborated": "", "unverified": "?", "suspect": "??"}
# Columns of the table of all wires.
HEAD = ("wire", "R cold [ohm]", "1 s [mA]", "catalogue", "holds", "for long", "supply [V]", "power [W]", "sense [V]",
        "slow sine [V]", "highest [V]", "V pulls [N]", "shunt [ohm]", "buy [W]")  # fmt: skip


def simulate_answer(sizing: SupplySizing, recording: Path | None) -> SimulateAnswer:
    """Return a drive's answer in SI and percent."""
    from musclewire.extras.supply._answers import SimulateAnswer, SuggestedParts
    from musclewire.extras.supply._sizing import catalogue_side

    numbers, plan, best, shunt = sizing.numbers, sizing.plan, sizing.one_second, sizing.shunt
    pulsed = plan.request.duty is not None
    answer = SimulateAnswer.read_from(
        numbers,
        plan,
        plan.request,
        sizing,
        simulated=True,
        spring_stiffness_n_per_m=plan.request.spring_n_per_m,
        ambient_temperature_degc=plan.request.ambient_k - ZERO_DEGC_K,
        shunt_resistance_ohm=plan.shunt_ohm,
        wire=plan.request.wire,
        duty=plan.pulses.on / plan.pulses.period,
        duty_period_s=plan.request.duty_period_s if pulsed else None,
        contraction_pct=100 * numbers.contraction,
        largest_contraction_pct=100 * numbers.max_contraction,
        final_contraction_pct=100 * numbers.final_contraction,
        last_period_pct=(100 * numbers.last_period_lowest, 100 * numbers.last_period_highest) if pulsed else None,
        contraction_m=numbers.contraction * plan.request.length_m,
        stroke_pct=100 * best.stroke,
        contraction_share_pct=100 * numbers.contraction / best.stroke,
        true_peak_temperature_degc=numbers.temperature_peak_k - ZERO_DEGC_K,
        settled_temperature_degc=sizing.settled_k - ZERO_DEGC_K,
        drive_voltage_peak_v=numbers.voltage_peak_v,
        suggested=SuggestedParts(
            one_second_current_a=best.current_a,
            holding_current_a=best.holding_current_a,
            supply_v=sizing.supply_needed_v,
            shunt_resistance_ohm=shunt.resistance_ohm,
            shunt_power_w=shunt.power_w,
            shunt_rating_w=shunt.rating_w,
        ),
        catalogue=catalogue_side(plan),
        samples=len(sizing.recording),
        recording=None if recording is None else str(recording),
    )
    return answer.model_copy(update=dict.fromkeys(NONE_OF_A_MOLTEN_WIRE)) if numbers.melted else answer


def answer_text(answer: SupplySizing, printed: CatalogueSide | None) -> str:
    """Return a drive's answer as lines for people."""
    numbers, plan, best = answer.numbers, answer.plan, answer.one_second
    length_mm = 1e3 * plan.request.length_m
    if numbers.melted:
        return "\n".join([f"{headline(plan)}: melted", *parts_lines(answer)])
    left_on = f"left on like this it would settle at {answer.settled_k - ZERO_DEGC_K:.0f} C"
    lines = [
        headline(plan),
        f"  contraction   {100 * numbers.contraction:.2f} % = {length_mm * numbers.contraction:.2f} mm, "
        f"{100 * numbers.contraction / best.stroke:.0f} % of a full stroke of {100 * best.stroke:.2f} %; "
        + ("90 % not reached" if numbers.contracted_s is None else f"90 % after {numbers.contracted_s:.2f} s"),
        f"{'':16}{100 * numbers.max_contraction:.2f} % at most, {100 * numbers.final_contraction:.2f} % when it ends",
        *period_lines(answer),
        f"  temperature   {numbers.temperature_peak_k - ZERO_DEGC_K:.0f} C at most (the simulation's truth; no "
        f"instrument shows it); {left_on}",
        f"  electrical    {amperes(numbers.current_mean_a)} on average, {numbers.voltage_peak_v:.2f} V and "
        f"{numbers.power_peak_w:.3g} W at most, {numbers.energy_j:.3g} J",
        "  cooling       " + cooling_words(answer),
        *parts_lines(answer),
    ]
    return "\n".join(lines + ([] if printed is None else catalogue_lines(printed)))


def parts_lines(answer: SupplySizing) -> list[str]:
    """Return which supply and shunt the wire needs to contract in a second, whatever it was driven by."""
    best, shunt, length_mm = answer.one_second, answer.shunt, 1e3 * answer.plan.request.length_m
    return [
        "",
        f"for 90 % of the stroke in one second, {length_mm:g} mm of this wire require",
        f"  current       {amperes(best.current_a)}; then {amperes(best.holding_current_a)} holds it there",
        f"  supply        {answer.supply_needed_v:.2f} V across wire and shunt, plus what the switch drops",
        f"  shunt         {shunt.resistance_ohm:g} ohm, {1e3 * shunt.power_w:.0f} mW: buy one for {shunt.rating_w:g} W",
    ]


def headline(plan: SupplyPlan) -> str:
    """Return the line that says what was simulated."""
    pull = f"{plan.load_n:.3g} N" + (
        f" on a spring of {plan.request.spring_n_per_m:g} N/m" if plan.request.spring_n_per_m else " dead weight"
    )
    source = "" if plan.supply_v is None or plan.current_a is None else f" from at most {plan.supply_v:g} V"
    driven = f"{plan.supply_v:g} V" if plan.current_a is None else amperes(plan.current_a) + source
    return (
        f"{plan.request.wire}, simulated: {1e3 * plan.request.length_m:g} mm, {pull}, still air of "
        f"{plan.request.ambient_k - ZERO_DEGC_K:g} C, {driven} through {plan.shunt_ohm:g} ohm for "
        f"{plan.request.on_s:g} s" + duty_words(plan)
    )


def duty_words(plan: SupplyPlan) -> str:
    """Return the square wave of a drive in words; nothing for one without pauses."""
    if plan.request.duty is None:
        return ""
    return f", on for {100 * plan.pulses.on / plan.pulses.period:.0f} % of every {plan.request.duty_period_s:g} s"


def period_lines(answer: SupplySizing) -> list[str]:
    """Return how far a pulsed wire moves to and fro, and how often; nothing for one without pauses."""
    request, numbers = answer.plan.request, answer.numbers
    if request.duty is None:
        return []
    moved = numbers.last_period_highest - numbers.last_period_lowest
    return [
        f"  to and fro    {100 * moved:.2f} % = {1e3 * request.length_m * moved:.2f} mm in the last period, from "
        f"{100 * numbers.last_period_lowest:.2f} to {100 * numbers.last_period_highest:.2f} %; "
        f"at {1.0 / request.duty_period_s:.3g} Hz"
    ]


def cooling_words(answer: SupplySizing) -> str:
    """Return the cooling time, or why there is none."""
    numbers = answer.numbers
    if numbers.cooling_s is not None:
        return f"{numbers.cooling_s:.2f} s after switching off, until 0.5 % of strain is left"
    if numbers.contraction <= 0.005:
        return "nothing to wait for: it contracted by less than the last 0.5 %, which is not counted"
    return "not cooled by the end of the run: simulate for longer"


def catalogue_lines(side: CatalogueSide) -> list[str]:
    """Return what the catalogue prints for the wire, each number with its standing."""
    current, cooling, ours = side.one_second_current_a, side.cooling_s, side.test_cooling_s
    rows = (
        ("for one second", amperes(current.value), current),
        ("cooling", f"{cooling.value:g} s", cooling),
        ("resistance", f"{side.resistance_ohm_per_m.value:g} ohm/m", side.resistance_ohm_per_m),
        ("pull", f"{side.pull_force_n.value:.3g} N", side.pull_force_n),
    )
    compared = (
        "the simulated wire does not cool below the last 0.5 % within that test"
        if ours is None
        else f"the simulated wire takes {ours:.2f} s in the vendor's test, {ours / cooling.value:.2f} times the "
        "catalogue's"
    )
    return [
        "",
        "the catalogue prints",
        *(f"  {label:<14}  {text} ({cell.status})" for label, text, cell in rows),
        f"  {'cooling':<14}  {compared}  (172 MPa, {amperes(current.value)} for one second, still air)",
    ]


def amperes(current_a: float) -> str:
    """Return a current as people write it."""
    return f"{1e3 * current_a:.0f} mA" if current_a < 1.0 else f"{current_a:.2f} A"


def wires() -> WiresAnswer:
    """Return all wires that come with musclewire."""
    from musclewire.extras.supply._answers import WireOfLibrary, WiresAnswer
    from musclewire.parameters import load_alloy, load_wire, names, validity_of

    loaded = [load_wire(name) for name in names("wire")]
    return WiresAnswer.read_from(
        wires=[
            WireOfLibrary.read_from(
                wire,
                diameter_m=wire.diameter_m.value,
                resistance_per_metre_ohm_per_m=wire.resistance_per_metre_ohm_per_m.value,
            )
            for wire in loaded
        ],
        alloys={name: validity_of(load_alloy(name)).facts() for name in names("alloy")},
    )


def wires_text(found: WiresAnswer) -> str:
    """Return all wires as lines: name, what it is; then what the data of their alloys cover."""
    covered = [f"alloy {name}: {covered_words(limits.model_dump())}" for name, limits in found.alloys.items()]
    rows = ((wire.name, wire.description) for wire in found.wires)
    return "\n".join([table(["", ""], rows, left=(0, 1)), "", *covered])


def covered_words(limits: dict[str, float]) -> str:
    """Return in words what an alloy's data cover and what its vendor allows."""
    if not limits:
        return "its file does not state what its data cover"
    low, high = (1e-6 * limits[f"covered_stress_{end}_pa"] for end in ("low", "high"))
    hottest, annealing = (
        limits[name] - ZERO_DEGC_K for name in ("covered_temperature_high_k", "annealing_temperature_k")
    )
    return (
        f"data cover {low:.0f} to {high:.0f} MPa and temperatures to {hottest:.0f} C; the vendor's stress for many "
        f"cycles is {1e-6 * limits['working_stress_pa']:.0f} MPa; above {annealing:.0f} C a wire may lose memory"
    )


def comparison_answer(compared: Sequence[CatalogueComparison]) -> CatalogueAnswer:
    """Return the comparison with the catalogue: a row for each wire, in order."""
    from musclewire.extras.supply._answers import CatalogueAnswer, ComparedWire
    from musclewire.extras.supply._catalogue_check import BARS

    verdicts = [one.ok for each in compared for one in (each.contraction, each.cooling)]
    rows = [
        ComparedWire.read_from(
            one,
            one.row,
            one.run,
            current_status=one.row.current_ma.status,
            stroke_pct=100 * one.run.stroke,
            contraction_share_pct=100 * one.run.contraction_fraction,
            contraction_ok=one.contraction.ok,
            true_temperature_degc=one.run.temperature_k - ZERO_DEGC_K,
            catalogue_cooling_s=one.cooling.cell.value,
            cooling_status=one.cooling.cell.status,
            cooling_ok=one.cooling.ok,
        )
        for one in compared
    ]
    judged, failed = sum(ok is not None for ok in verdicts), verdicts.count(False)
    return CatalogueAnswer.read_from(
        bars=BARS, rows=rows, judged=judged, failed=failed, ok=all(one.ok for one in compared)
    )


def comparison_text(compared: Sequence[CatalogueComparison], answer: CatalogueAnswer) -> str:
    """Return the comparison as a table: a line for each size, 70 C wire and 90 C wire side by side."""
    from musclewire.parameters import load_catalogue

    head = (
        "mm",
        "mA",
        *(f"{wire} {what}" for wire in ("LT", "HT") for what in ("% of stroke", "cooling s", "catalogue")),
    )
    rows = (
        [
            low.row.name,
            marked(low.row.current_ma.value, low.row.current_ma),
            *(
                text
                for one in (low, high)
                for text in (
                    judged_text(one.contraction, 100.0, 1),
                    judged_text(one.cooling, 1.0, 2),
                    marked(one.cooling.cell.value, one.cooling.cell),
                )
            ),
        ]
        for low, high in zip(compared[::2], compared[1::2], strict=True)
    )
    missed = f"{answer.failed} missed, marked FAIL" if answer.failed else "all within the bars"
    return "\n".join(
        [
            "172 MPa dead weight, the catalogue's current for one second, still air of 22 C; simulated wires: 70 C",
            "wire (LT), and 90 C wire (HT), which is not judged",
            "",
            table(head, rows, left=()),
            "",
            f"{answer.judged} judged, {missed}. {answer.bars}.",
            "? the catalogue's number is not corroborated. Cooling: from switching off after the second until 0.5 % of",
            "strain is left; - where the wire did not contract by that much.",
            f"Catalogue: {load_catalogue().source}.",
        ]
    )


def marked(value: float, cell: CatalogueCell) -> str:
    """Return a catalogue number with a question mark where it is not corroborated."""
    return f"{value:g}{MARKS[cell.status]}"


def judged_text(one: JudgedValue, scale: float, digits: int) -> str:
    """Return a number of ours with its verdict."""
    shown = "-" if one.ours is None else f"{scale * one.ours:.{digits}f}"
    return shown if one.ok is None else f"{shown} {'ok' if one.ok else 'FAIL'}"


def table_answer(rows: Sequence[WireRow], length_m: float, stress_pa: float, ambient_k: float) -> WireTableAnswer:
    """Return the table: a row for each wire, in order; SI."""
    from musclewire.extras.supply._answers import WireTableAnswer

    return WireTableAnswer.read_from(
        length_m=length_m,
        stress_pa=stress_pa,
        ambient_temperature_degc=ambient_k - ZERO_DEGC_K,
        simulated=True,
        rows=[row_keys(row) for row in rows],
    )


def row_keys(row: WireRow) -> dict[str, Any]:
    """Return one wire of the table."""
    keys = row._asdict()
    shunt, cell = keys.pop("shunt"), keys.pop("catalogue_current")
    keys |= {f"shunt_{name}": value for name, value in shunt._asdict().items()}
    return {**keys, "catalogue_current_a": 1e-3 * cell.value, "catalogue_current_status": cell.status}


def table_text(rows: Sequence[WireRow], length_m: float, stress_pa: float, ambient_k: float) -> str:
    """Return the table as lines."""
    air = f"still air of {ambient_k - ZERO_DEGC_K:g} C"
    lines = [
        f"{1e3 * length_m:g} mm of wire, {stress_pa / 1e6:.0f} MPa, {air}; simulated",
        "",
        table(HEAD, map(cells, rows)),
        "",
        "1 s: contracts by 90 % in a second; then lower it to what holds. For long: at most 150 C, a working limit",
        "(assumed). Supply across wire and shunt at the one-second current, power in the wire; the switch or amplifier",
        "comes on top. ? the catalogue's number is not corroborated. Sense, slow sine, highest, V pulls, shunt: a rig",
        "file's sense_voltage, drive_amplitude, maximum_voltage, pretension of a V (twice the vendor's bias force) and",
        "shunt, which reads the current for long within 250 mV.",
    ]
    return "\n".join(lines)


def cells(row: WireRow) -> tuple[str, ...]:
    """Return one wire as the cells of its row."""
    printed, shunt = row.catalogue_current, row.shunt
    currents_a = (row.holding_current_a, row.lasting_current_a)
    return (
        row.wire,
        f"{row.cold_resistance_ohm:.4g}",
        f"{1e3 * row.one_second_current_a:.0f}",
        f"{printed.value:g}{MARKS[printed.status]}",
        *(f"{1e3 * current_a:.0f}" for current_a in currents_a),
        f"{row.supply_v:.2f}",
        f"{row.power_w:.3g}",
        f"{row.sense_voltage_v:.3f}",
        f"{row.amplitude_v:.2f}",
        f"{row.maximum_voltage_v:.2f}",
        f"{row.pretension_n:.3g}",
        f"{shunt.resistance_ohm:g}",
        f"{shunt.rating_w:g}",
    )
