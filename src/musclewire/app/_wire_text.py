"""How a simulated drive, the list of wires and the catalogue's comparison read: as text, and as keys for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from musclewire.experiment import SupplyPlan, SupplySizing
    from musclewire.identify import CatalogueComparison, JudgedValue
    from musclewire.parameters import CatalogueCell

__all__ = ["answer_json", "answer_text", "comparison_json", "comparison_text", "wires_json", "wires_text"]

ZERO_DEGC_K = 273.15
MARKS = {"corroborated": "", "unverified": "?", "suspect": "??"}


def answer_json(answer: SupplySizing, recording: Path | None) -> dict[str, Any]:
    """Return a drive's answer under the keys of the interface."""
    from musclewire.experiment import catalogue_side

    numbers, plan, best = answer.numbers, answer.plan, answer.one_second
    return {
        "wire": plan.request.wire,
        "simulated": True,
        "length_m": plan.request.length_m,
        "load_n": plan.load_n,
        "spring_stiffness_n_per_m": plan.request.spring_n_per_m,
        "ambient_temperature_degc": plan.request.ambient_k - ZERO_DEGC_K,
        "supply_v": plan.supply_v,
        "current_a": plan.current_a,
        "shunt_resistance_ohm": plan.shunt_ohm,
        "on_s": plan.request.on_s,
        "duty": plan.pulses.on / plan.pulses.period,
        "duty_period_s": None if plan.request.duty is None else plan.request.duty_period_s,
        "contraction_pct": 100 * numbers.contraction,
        "largest_contraction_pct": 100 * numbers.max_contraction,
        "final_contraction_pct": 100 * numbers.final_contraction,
        "last_period_pct": None
        if plan.request.duty is None
        else [100 * numbers.last_period_lowest, 100 * numbers.last_period_highest],
        "contraction_m": numbers.contraction * plan.request.length_m,
        "stroke_pct": 100 * best.stroke,
        "contraction_share_pct": 100 * numbers.contraction / best.stroke,
        "contracted_s": numbers.contracted_s,
        "cooling_s": numbers.cooling_s,
        "true_peak_temperature_degc": numbers.temperature_peak_k - ZERO_DEGC_K,
        "settled_temperature_degc": answer.settled_k - ZERO_DEGC_K,
        "current_mean_a": numbers.current_mean_a,
        "drive_voltage_peak_v": numbers.voltage_peak_v,
        "power_peak_w": numbers.power_peak_w,
        "energy_j": numbers.energy_j,
        "suggested": {
            "one_second_current_a": best.current_a,
            "holding_current_a": best.holding_current_a,
            "supply_v": answer.supply_needed_v,
            "shunt_resistance_ohm": answer.shunt.resistance_ohm,
            "shunt_power_w": answer.shunt.power_w,
            "shunt_rating_w": answer.shunt.rating_w,
        },
        "catalogue": catalogue_side(plan),
        "warnings": list(answer.warnings),
        "samples": len(answer.recording),
        "seed": plan.request.seed,
        "recording": None if recording is None else str(recording),
    }


def answer_text(answer: SupplySizing) -> str:
    """Return a drive's answer as lines for people."""
    numbers, plan, best, shunt = answer.numbers, answer.plan, answer.one_second, answer.shunt
    length_mm = 1e3 * plan.request.length_m
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
        "",
        f"for 90 % of the stroke in one second, {length_mm:g} mm of this wire require",
        f"  current       {amperes(best.current_a)}; then {amperes(best.holding_current_a)} holds it there",
        f"  supply        {answer.supply_needed_v:.2f} V across wire and shunt, plus what the switch drops",
        f"  shunt         {shunt.resistance_ohm:g} ohm, {1e3 * shunt.power_w:.0f} mW: buy one for {shunt.rating_w:g} W",
    ]
    return "\n".join(lines + catalogue_lines(plan))


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
        f"{1.0 / request.duty_period_s:.3g} times a second"
    ]


def cooling_words(answer: SupplySizing) -> str:
    """Return the cooling time, or why there is none."""
    numbers = answer.numbers
    if numbers.cooling_s is not None:
        return f"{numbers.cooling_s:.2f} s after switching off, until 0.5 % of strain is left"
    if numbers.contraction <= 0.005:
        return "nothing to wait for: it contracted by less than the last 0.5 %, which is not counted"
    return "not cooled by the end of the run: give a longer --duration"


def catalogue_lines(plan: SupplyPlan) -> list[str]:
    """Return what the catalogue prints for the wire, each number with its standing."""
    from musclewire.experiment import catalogue_side

    side = catalogue_side(plan)
    if side is None:
        return []
    shown = {
        "for one second": ("one_second_current_a", amperes(side["one_second_current_a"]["value"])),
        "cooling": ("cooling_s", f"{side['cooling_s']['value']:g} s"),
        "resistance": ("resistance_ohm_per_m", f"{side['resistance_ohm_per_m']['value']:g} ohm/m"),
        "pull": ("pull_force_n", f"{side['pull_force_n']['value']:.3g} N"),
    }
    lines = [f"  {label:<14}  {text} ({side[key]['status']})" for label, (key, text) in shown.items()]
    ours, theirs = side["test_cooling_s"], side["cooling_s"]["value"]
    compared = (
        "the simulated wire does not cool below the last 0.5 % within that test"
        if ours is None
        else f"the simulated wire takes {ours:.2f} s in the vendor's test, {ours / theirs:.2f} times the catalogue's"
    )
    test = f"  (172 MPa, {amperes(side['one_second_current_a']['value'])} for one second, still air)"
    return ["", "the catalogue prints", *lines, f"  {'cooling':<14}  {compared}{test}"]


def amperes(current_a: float) -> str:
    """Return a current as people write it."""
    return f"{1e3 * current_a:.0f} mA" if current_a < 1.0 else f"{current_a:.2f} A"


def wires_json() -> dict[str, Any]:
    """Return all wires that come with musclewire."""
    from musclewire.parameters import load_alloy, load_wire, names, validity_of

    return {
        "wires": [
            {
                "name": name,
                "description": load_wire(name).description,
                "alloy": load_wire(name).alloy,
                "diameter_m": load_wire(name).diameter_m.value,
                "resistance_per_metre_ohm_per_m": load_wire(name).resistance_per_metre_ohm_per_m.value,
            }
            for name in names("wire")
        ],
        "alloys": {name: validity_of(load_alloy(name)).facts() for name in names("alloy")},
    }


def wires_text() -> str:
    """Return all wires as lines: name, what it is; then what the data of their alloys cover."""
    document = wires_json()
    lines = [f"{row['name']:<18} {row['description']}" for row in document["wires"]]
    covered = [f"alloy {name}: {covered_words(limits)}" for name, limits in document["alloys"].items()]
    return "\n".join([*lines, "", *covered])


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


def comparison_json(compared: Sequence[CatalogueComparison]) -> dict[str, Any]:
    """Return the comparison with the catalogue: a row for each wire, in order."""
    from musclewire.identify import BARS

    return {
        "bars": BARS,
        "rows": [row_json(one) for one in compared],
        "judged": sum(verdict is not None for one in compared for verdict in (one.contraction.ok, one.cooling.ok)),
        "failed": sum(verdict is False for one in compared for verdict in (one.contraction.ok, one.cooling.ok)),
        "ok": all(one.ok for one in compared),
    }


def row_json(one: CatalogueComparison) -> dict[str, Any]:
    """Return one wire of the comparison."""
    return {
        "wire": one.wire,
        "diameter_m": one.row.diameter_m,
        "current_a": one.row.current_a,
        "current_status": one.row.current_ma.status,
        "stroke_pct": 100 * one.run.stroke,
        "contraction_share_pct": 100 * one.run.contraction_fraction,
        "contraction_ok": one.contraction.ok,
        "true_temperature_degc": one.run.temperature_k - ZERO_DEGC_K,
        "cooling_s": one.run.cooling_s,
        "catalogue_cooling_s": one.cooling.cell.value,
        "cooling_status": one.cooling.cell.status,
        "cooling_ok": one.cooling.ok,
        "ok": one.ok,
    }


def comparison_text(compared: Sequence[CatalogueComparison]) -> str:
    """Return the comparison as a table: a line for each size, 70 C wire and 90 C wire side by side."""
    from musclewire.identify import BARS
    from musclewire.parameters import load_catalogue

    lines = [
        "172 MPa dead weight, the catalogue's current for one second, still air of 22 C; simulated wires",
        "",
        "             | 70 C wire (LT)                       | 90 C wire (HT), not judged",
        "  mm      mA | % of stroke     cooling s  catalogue | % of stroke  cooling s  catalogue",
    ]
    for low, high in zip(compared[::2], compared[1::2], strict=True):
        current = marked(low.row.current_ma.value, low.row.current_ma)
        lines.append(
            f"{low.row.name:>5} {current:>7} | {judged_text(low.contraction, 100.0, 1):>11} "
            f"{judged_text(low.cooling, 1.0, 2):>14}  {marked(low.cooling.cell.value, low.cooling.cell):>8} | "
            f"{judged_text(high.contraction, 100.0, 1):>11} {judged_text(high.cooling, 1.0, 2):>10}  "
            f"{marked(high.cooling.cell.value, high.cooling.cell):>8}".rstrip()
        )
    document = comparison_json(compared)
    missed = f"{document['failed']} missed, marked FAIL" if document["failed"] else "all within the bars"
    lines += [
        "",
        f"{document['judged']} judged, {missed}. {BARS}.",
        "? the catalogue's number is not corroborated. Cooling: from switching off after the second until 0.5 % of",
        "strain is left; - where the wire did not contract by that much.",
        f"Catalogue: {load_catalogue().source}.",
    ]
    return "\n".join(lines)


def marked(value: float, cell: CatalogueCell) -> str:
    """Return a catalogue number with a question mark where it is not corroborated."""
    return f"{value:g}{MARKS[cell.status]}" if MARKS[cell.status] else f"{value:g} "


def judged_text(one: JudgedValue, scale: float, digits: int) -> str:
    """Return a number of ours with its verdict."""
    shown = "-" if one.ours is None else f"{scale * one.ours:.{digits}f}"
    return shown if one.ok is None else f"{shown} {'ok' if one.ok else 'FAIL'}"
