"""The page reference/parameters of the site, from the parameter files: every number with its published range."""

from __future__ import annotations

import math
import textwrap
from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from scipy.special import ndtri

from musclewire.parameters import (
    Alloy,
    Bench,
    Parameter,
    PublishedRange,
    Wire,
    load_alloy,
    load_bench,
    load_priors,
    load_wire,
    published_ranges,
)
from musclewire.wire import SHAPE, two_populations

ALLOY, BENCH = "flexinol", "paper"
WIRES = ("paper-100um", "paper-125um", "paper-200um", "finger-100um", "isobar-sample")
EXAMPLE_STRESS_PA = 100e6
# The wire whose resistance per metre the alloy's resistivities belong to.
REFERENCE_WIRE = "paper-100um"
ZERO_DEGC_K = 273.15
# How SI is shown: factor and unit. Temperatures go to degrees Celsius, strains to percent.
SHOWN = {
    "Pa": (1e-9, "GPa"),
    "Pa/K": (1e-6, "MPa/K"),
    "K/Pa": (1e9, "K/GPa"),
    "1/K": (1e6, "ppm/K"),
    "ohm m": (1e6, "µohm m"),
    "J/kg": (1e-3, "kJ/kg"),
}
HEAD = """# Parameters of the simulated wire, one by one

For researchers who look up a number of the simulated wire, and what is published about it.
See also [how the values were found](../explanation/parameters.md), [their
equations](../explanation/physics.md) and [symbols](symbols.md).

The files hold SI; here prefixes, percent and degrees Celsius are used. "Published" reaches from the lowest to the
highest figure found for NiTi actuator wire. One figure is no range: for such a parameter the table has the ratio of our
value to it.
"""


def page() -> str:
    """Return the whole page."""
    alloy, bench = load_alloy(ALLOY), load_bench(BENCH)
    wires = [load_wire(name) for name in WIRES]
    parts = [
        HEAD,
        f"## Alloy `{ALLOY}`\n\n{alloy.description}.\n\n{alloy_table(alloy)}",
        f"## Outside what is published\n\n{outside_text(alloy, wires, bench)}\n\n{former_text(alloy)}",
        f"## What follows from them\n\n{paragraphs(DERIVED_TEXT)}\n\n{derived_table(alloy)}",
        f"## Wires\n\n{paragraphs(WIRES_TEXT)}\n\n{wires_table(wires)}",
        f"## Bench `{BENCH}`\n\n{bench.description}.\n\n{bench_table(bench)}",
        f"## Where the values come from\n\n{sources_table([alloy, *wires])}",
        f"## Where the published figures come from\n\n{published_table()}",
        f"## Before anything is measured\n\n{paragraphs(PRIORS_TEXT)}\n\n{priors_table()}",
    ]
    return "\n".join(part.rstrip("\n") + "\n" for part in parts)


def paragraphs(text: str) -> str:
    """Return paragraphs with their lines filled again: numbers in them change."""
    return "\n\n".join(textwrap.fill(each, 118, break_on_hyphens=False) for each in text.split("\n\n"))


def table(header: list[str], rows: list[list[str]]) -> str:
    """Return a Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def scaled(name: str, unit: str) -> tuple[float, float, str]:
    """Return factor, offset and unit in which a parameter is shown."""
    if name == "strain_stress_scale_pa":
        return 1e-6, 0.0, "MPa"
    if name in ("martensite_temperature_k", "r_phase_temperature_k", "ambient_temperature_k"):
        return 1.0, -ZERO_DEGC_K, "°C"
    if name in ("diameter_m", "guide_presliding_m", "displacement_noise_m"):
        return 1e6, 0.0, "µm"
    if unit == "1" and "strain" in name:
        return 100.0, 0.0, "%"
    factor, shown = SHOWN.get(unit, (1.0, unit))
    return factor, 0.0, "" if shown == "1" else shown


def figure(value: float) -> str:
    """Return a number with four digits."""
    return f"{value:.4g}"


def shown(value: float, name: str, unit: str) -> str:
    """Return a value with the unit of this page."""
    factor, offset, words = scaled(name, unit)
    return f"{figure(factor * value + offset)} {words}".strip()


def shown_range(found: PublishedRange, name: str) -> str:
    """Return a published range, or its one figure."""
    if found.is_one_figure:
        return shown(found.low, name, found.unit)
    factor, offset, words = scaled(name, found.unit)
    return f"{figure(factor * found.low + offset)} to {figure(factor * found.high + offset)} {words}".strip()


def verdict(value: float, name: str, found: PublishedRange | None) -> str:
    """Return whether a value lies inside what is published, and how far outside else."""
    if found is None:
        return "nothing found"
    if found.is_one_figure:
        return (
            "the one figure" if found.excess(value) == 0.0 else f"one figure; ours is {value / found.low:.2g} times it"
        )
    beyond = found.excess(value)
    if beyond == 0.0:
        return "yes"
    factor, _, words = scaled(name, found.unit)
    words = "K" if words == "°C" else words
    return f"**no**, {figure(factor * abs(beyond))} {words} {'above' if beyond > 0.0 else 'below'}".replace("  ", " ")


def meaning(group: type[Alloy] | type[Wire] | type[Bench], name: str) -> str:
    """Return what the schema says of a parameter."""
    return str(group.model_fields[name].description)


def alloy_table(alloy: Alloy) -> str:
    """Return every parameter of the alloy with kind, published range and verdict."""
    ranges = published_ranges().parameters
    rows = []
    for name, item in alloy.items():
        found = ranges.get(name)
        standing = "" if found is None or found.standing == "looked up" else f" ({found.standing})"
        rows.append(
            [
                f"`{name}`",
                meaning(Alloy, name),
                shown(item.value, name, item.unit),
                item.kind,
                "" if found is None else shown_range(found, name) + standing,
                verdict(item.value, name, found),
            ]
        )
    return table(["parameter", "symbol, meaning", "value", "kind", "published", "inside"], rows)


def outside_rows(groups: Sequence[Alloy | Wire | Bench]) -> list[list[str]]:
    """Return file, parameter, value, range and the file's reason of everything that left its published range."""
    rows = []
    for group in groups:
        for name, item in outside(group).items():
            found = published_ranges().parameters[name]
            rows.append([group.name, name, shown(item.value, name, item.unit), shown_range(found, name), item.note])
        if isinstance(group, Wire):
            for name, value in outside_as_a_spool(group).items():
                found = spool_ranges(group)[name]
                note = "spools may differ by this from their alloy"
                rows.append([group.name, name, spool_shown(value, found), spool_range(found), note])
    return rows


def outside_text(alloy: Alloy, wires: list[Wire], bench: Bench) -> str:
    """Return how many numbers left their published range, and each with the reason its file gives."""
    rows = outside_rows([alloy, *wires, bench])
    count = f"`python checks/published_ranges.py` counts: **{len(rows)}** outside."
    if not rows:
        return f"{count} Every parameter of alloy, wires and bench for which a range was found lies inside it."
    cells = [
        [f"`{group}`", f"`{name}`", value, found, note or "**no reason given**"]
        for group, name, value, found, note in rows
    ]
    return f"{count}\n\n{table(['file', 'parameter', 'value', 'published', 'what is said of it'], cells)}"


FORMER_TEXT = """Some ranges were widened, with the sources below, after one fit and before that which ships.
By the former ranges **{}** of the alloy's parameters are outside, and **{}** more miss the only figure there was; of
what follows from several parameters **{}** are outside, and **{}** by the new ranges."""


def former_rows(alloy: Alloy) -> list[tuple[str, str, PublishedRange, float]]:
    """Return kind, name, range and our value of what has a range and is outside, now or before it was widened."""
    published = published_ranges()
    values = [("parameter", name, published.parameters.get(name), item.value) for name, item in alloy.items()]
    values += [("follows", name, published.derived.get(name), value) for name, _, value, _, _ in derived(alloy)]
    return [
        (kind, name, found, value)
        for kind, name, found, value in values
        if found is not None and (found.former or not found.is_one_figure)
        if found.excess(value) != 0.0 or found.before.excess(value) != 0.0
    ]


def former_counts(alloy: Alloy) -> tuple[int, int, int, int]:
    """Return how many parameters former ranges leave outside, and one figure; how many that follow, former and new."""
    rows = former_rows(alloy)
    one = sum(found.before.is_one_figure for _, _, found, _ in rows)
    parameters = sum(kind == "parameter" for kind, _, _, _ in rows)
    now = sum(kind == "follows" and found.excess(value) != 0.0 for kind, _, found, value in rows)
    return parameters - one, one, len(rows) - parameters, now


def former_text(alloy: Alloy) -> str:
    """Return how many values are outside by the ranges before they were widened, and each by both."""
    rows = [
        [
            f"`{name}`",
            shown(value, name, found.unit),
            shown_range(found.before, name),
            verdict(value, name, found.before),
            shown_range(found, name) if found.former else "the same",
            verdict(value, name, found),
        ]
        for _, name, found, value in former_rows(alloy)
    ]
    header = ["quantity", "value", "published, former", "inside", "published, now", "inside"]
    return f"{paragraphs(FORMER_TEXT.format(*former_counts(alloy)))}\n\n{table(header, rows)}"


def spool_shown(value: float, found: PublishedRange) -> str:
    """Return what a spool differs in; differences of temperature stay kelvin."""
    return f"{figure(value)} {'' if found.unit == '1' else found.unit}".strip()


def spool_range(found: PublishedRange) -> str:
    """Return the range of what a spool may differ in."""
    return f"{figure(found.low)} to {spool_shown(found.high, found)}"


DERIVED_TEXT = f"""No file holds these; they follow from the alloy's parameters and can be held against measurements.
Stress dependent ones are given at {EXAMPLE_STRESS_PA * 1e-6:.0f} MPa, temperatures without a wire's own shift. What
lies outside here does so for the same reasons as the parameters behind it.

Two rows compare what thermodynamics ties together: a Clausius-Clapeyron slope C, a strain H and a temperature T ask for
the heat C H T / density. The model does not impose this. The distance from the heat that it uses shows how far its
parameters are from those of one consistent free energy."""


def derived(alloy: Alloy) -> list[tuple[str, str, float, str, str]]:
    """Return name, meaning, value, unit and remark of what follows from the alloy's parameters."""
    a, stress = alloy.values(), EXAMPLE_STRESS_PA
    strain = a["strain_saturated"] - (a["strain_saturated"] - a["strain_at_no_stress"]) * float(
        np.exp(-stress / a["strain_stress_scale_pa"])
    )
    barrier = a["martensite_barrier_k"] + a["martensite_barrier_per_pa"] * stress
    spread = a["martensite_spread_k"] + a["martensite_spread_per_pa"] * stress
    tails = two_populations(ndtri(np.array([0.1, 0.9])), *(a[name] for name in SHAPE))
    of_slope = a["martensite_stress_rate_pa_per_k"] * strain * a["martensite_temperature_k"] / a["density_kg_per_m3"]
    of_r = a["r_phase_stress_rate_pa_per_k"] * a["r_phase_strain"] * a["r_phase_temperature_k"] / a["density_kg_per_m3"]
    latent_r = a["r_phase_entropy_ratio"] * a["latent_heat_j_per_kg"]
    return [
        ("martensite_hysteresis_k", "2 h_M: between the branches of the middle grain", 2.0 * barrier, "K", ""),
        ("martensite_width_k", "10 to 90 % of the grains on one branch", spread * float(np.ptp(tails)), "K", ""),
        (
            "clausius_clapeyron_latent_heat_j_per_kg",
            "C_M H T_M0 / density",
            of_slope,
            "J/kg",
            f"the model uses {shown(a['latent_heat_j_per_kg'], '', 'J/kg')}",
        ),
        (
            "r_phase_clausius_clapeyron_heat_j_per_kg",
            "C_R H_R T_R0 / density",
            of_r,
            "J/kg",
            f"the model uses r times the latent heat, {shown(latent_r, '', 'J/kg')}",
        ),
        (
            "transformation_entropy_j_per_kg_k",
            "latent heat / T_M0",
            a["latent_heat_j_per_kg"] / a["martensite_temperature_k"],
            "J/(kg K)",
            "",
        ),
        (
            "r_phase_hysteresis_k",
            "2 h_R / r: between the branches of the R-phase",
            2.0 * a["r_phase_barrier_k"] / max(a["r_phase_entropy_ratio"], 1e-9),
            "K",
            "",
        ),
        (
            "r_to_m_barrier_acting_k",
            "effective h_RM: at most h_M + h_R",
            min(a["r_to_m_barrier_k"], barrier + a["r_phase_barrier_k"]),
            "K",
            f"the file has {shown(a['r_to_m_barrier_k'], '', 'K')}",
        ),
    ]


def derived_table(alloy: Alloy) -> str:
    """Return quantities that follow from the parameters, with their published ranges."""
    ranges = published_ranges().derived
    rows = []
    for name, words, value, unit, remark in derived(alloy):
        found = ranges.get(name)
        published = "" if found is None else shown_range(found, name)
        rows.append([words, shown(value, name, unit), published, verdict(value, name, found), remark])
    return table(["quantity", "value", "published", "inside", "remark"], rows)


WIRES_TEXT = """The numbers of one spool; all others are the alloy's. `finger-100um` is the wire of the
paper's finger, taken to be a spool of its own
([why](../explanation/decisions/grains-and-spools.md)). The isobar sample is the wire behind the
published isobars. Their diameter and class are not stated with them; at 172 MPa it begins to transform near where wire
of the 90 °C class does ([turns and minor loops](../explanation/turns_and_minor_loops.md))."""


def wires_table(wires: list[Wire]) -> str:
    """Return the wires in columns; each value is followed by its kind."""
    rows = []
    for name, _ in wires[0].items():
        items: list[Parameter] = [getattr(wire, name) for wire in wires]
        found = published_ranges().parameters.get(name)
        cells = [f"{shown(item.value, name, item.unit)}, {item.kind}" for item in items]
        rows.append([f"`{name}`", *cells, "" if found is None else shown_range(found, name)])
    parameters = table(["parameter", *(f"`{wire.name}`" for wire in wires), "published"], rows)
    return f"{parameters}\n\n{paragraphs(SPOOLS_TEXT)}\n\n{spools_table(wires)}"


SPOOLS_TEXT = """How far each spool is from its alloy, and how far a spool may be: both temperatures with all shifts
that act on them, resistivity over what resistance per metre and diameter as printed ask for, and half of the hysteresis
with the spool's own shift."""


def spools_table(wires: list[Wire]) -> str:
    """Return what each spool differs in from its alloy; what is outside its range is bold, with that range."""
    rows = []
    for name, common in published_ranges().spools.items():
        cells = []
        for wire in wires:
            value, found = spool_values(wire)[name], spool_ranges(wire)[name]
            text = spool_shown(value, found) if found.excess(value) == 0.0 else f"**{spool_shown(value, found)}**"
            cells.append(text if found == common else f"{text} (of {spool_range(found)})")
        rows.append([f"`{name}`", *cells, spool_range(common)])
    return table(["difference", *(f"`{wire.name}`" for wire in wires), "spools may"], rows)


def bench_table(bench: Bench) -> str:
    """Return the bench's parameters with kind and source."""
    rows = [
        [f"`{name}`", meaning(Bench, name), shown(item.value, name, item.unit), item.kind, with_note(item)]
        for name, item in bench.items()
    ]
    return table(["parameter", "meaning", "value", "kind", "source"], rows)


def with_note(item: Parameter) -> str:
    """Return the source of a value, and its note."""
    return f"{item.source}; {item.note}" if item.note else item.source


def sources_table(groups: list[Alloy | Wire]) -> str:
    """Return every source with the parameters that have it, and notes."""
    by_source: dict[tuple[str, str], list[str]] = defaultdict(list)
    for group in groups:
        for name, item in group.items():
            words = f"`{name}`"
            if words not in by_source[item.kind, item.source]:
                by_source[item.kind, item.source].append(words)
    rows = [[kind, source, ", ".join(names)] for (kind, source), names in by_source.items()]
    notes = [
        [f"`{name}`", item.note] for name, item in groups[0].items() if item.note and name not in outside(groups[0])
    ]
    text = table(["kind", "source", "parameters"], rows)
    return f"{text}\n\nNotes of the alloy's file:\n\n{table(['parameter', 'note'], notes)}" if notes else text


def published_table() -> str:
    """Return every published range with its source and its standing."""
    rows = [
        [f"`{name}`", shown_range(found, name), found.standing, found.source]
        for name, found in published_ranges().parameters.items()
    ]
    for name, found in published_ranges().derived.items():
        words = name.removesuffix(unit_suffix(found)).replace("_", " ")
        rows.append([words, shown_range(found, name), found.standing, found.source])
    spools = [("a spool", published_ranges().spools)]
    spools += [(f"`{wire}`", ranges) for wire, ranges in published_ranges().spools_of.items()]
    for whose, ranges in spools:
        for name, found in ranges.items():
            rows.append([f"`{name}` of {whose}", spool_range(found), found.standing, found.source])
    return table(["quantity", "published", "standing", "source"], rows)


def unit_suffix(found: PublishedRange) -> str:
    """Return the ending of names with that unit."""
    return {"K": "_k", "J/kg": "_j_per_kg", "J/(kg K)": "_j_per_kg_k"}[found.unit]


PRIORS_TEXT = """What `parameters:load_priors` assumes of a wire before any measurement: a normal
distribution truncated at bounds, and the experiment that identifies the parameter best. The bounds are wider than the
published ranges on purpose: they are where a search stops."""


def priors_table() -> str:
    """Return the shipped priors."""
    rows = []
    for name, prior in load_priors().parameters.items():
        factor, offset, words = scaled(name, prior.unit)
        wide = "K" if words == "°C" else words
        rows.append(
            [
                f"`{name}`",
                f"{figure(factor * prior.mean + offset)} {words}".strip(),
                f"{figure(factor * prior.std)} {wide}".strip(),
                f"{figure(factor * prior.low + offset)} to {figure(factor * prior.high + offset)} {words}".strip(),
                prior.measure,
            ]
        )
    return table(["parameter", "mean", "deviation", "bounds", "experiment"], rows)


def outside(group: Alloy | Wire | Bench) -> dict[str, Parameter]:
    """Return the parameters of a file that lie outside their published range; one figure makes no range."""
    ranges = published_ranges().parameters
    return {
        name: item
        for name, item in group.items()
        if name in ranges and not ranges[name].is_one_figure and ranges[name].excess(item.value) != 0.0
    }


def spool_values(wire: Wire) -> dict[str, float]:
    """Return what a spool differs in from its alloy, by the names of ``PublishedRanges.spools``, in SI."""
    values, alloy = wire.values(), load_alloy(wire.alloy).values()
    reference = load_wire(REFERENCE_WIRE).values()
    nominal = nominal_resistivity_ohm_m(values) / nominal_resistivity_ohm_m(reference)
    return {
        "temperature_shift_k": values["temperature_shift_k"],
        "r_phase_temperature_shift_k": values["temperature_shift_k"] + values["r_phase_shift_k"],
        "resistivity_over_nominal": values["resistivity_factor"] / reference["resistivity_factor"] / nominal,
        "martensite_barrier_k": alloy["martensite_barrier_k"] + values["martensite_barrier_shift_k"],
    }


def nominal_resistivity_ohm_m(wire: dict[str, float]) -> float:
    """Return resistance per metre times section."""
    return wire["resistance_per_metre_ohm_per_m"] * math.pi / 4.0 * wire["diameter_m"] ** 2


def spool_ranges(wire: Wire) -> dict[str, PublishedRange]:
    """Return what may lie between a spool and its alloy, by the names of ``spool_values``."""
    ranges = published_ranges()
    return ranges.spools | ranges.spools_of.get(wire.name, {})


def outside_as_a_spool(wire: Wire) -> dict[str, float]:
    """Return in what a spool differs from its alloy by more than spools may, with its values.

    A barrier without a shift of the spool's own is the alloy's, and counts there alone.
    """
    ranges, values = spool_ranges(wire), spool_values(wire)
    if wire.martensite_barrier_shift_k.value == 0.0:
        del values["martensite_barrier_k"]
    return {name: value for name, value in values.items() if ranges[name].excess(value) != 0.0}
