"""The numbers of "What closes it in a wire with 20 K of hysteresis" in docs/explanation/physics.md."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from balance_runs import (
    BALANCE_WIRES,
    FORCE_RATIOS,
    STRESSES_MPA,
    Balance,
    balances,
    changed_wires,
    half_hysteresis_k,
    loop_at_ratio,
    measured_distance_k,
    measured_distances_k,
    other_spool,
    published_coefficients,
)
from parameter_page import paragraphs, table

from musclewire.parameters import load_alloy, published_ranges

ZERO_DEGC_K = 273.15
PHASES = ("austenite", "r_phase", "martensite")
# Force ratios at which the page shows the wires that differ from the shipped ones: first, middle and last.
SHOWN_RATIOS = FORCE_RATIOS[::2]


def blocks() -> dict[str, str]:
    """Return the text between the section's markers, by their names."""
    found = {wire: balances(wire) for wire in BALANCE_WIRES}
    return {
        "balance_temperature": paragraphs(temperature_text(found)),
        "balance": paragraphs(balance_text(found)),
        "balance_r_phase": paragraphs(r_phase_text()),
        "balance_barrier": barrier_table(),
        "balance_without": paragraphs(changes_text()),
    }


def balance_text(found: dict[str, list[Balance]]) -> str:
    """Return what R-phase, and all parts together, make of the difference at the least and the largest pretension."""
    wires = [
        f"in the {title(wire)} {1e3 * rows[0].r_phase:+.0f} mohm at a force ratio of {FORCE_RATIOS[0]:.2f} and "
        f"{1e3 * rows[-1].r_phase:+.0f} mohm at {FORCE_RATIOS[-1]:.2f}, with all other parts "
        f"{1e3 * rows[0].whole:+.0f} and {1e3 * rows[-1].whole:+.0f} mohm"
        for wire, rows in found.items()
    ]
    return f"It makes, as a mean over the strain that both branches have, {'; '.join(wires)}."


def changes_text() -> str:
    """Return the signed gap at the least pretension as shipped, without an R-phase, and as the other spool."""
    ratio, without = FORCE_RATIOS[0], changed_wires()["without an R-phase"]
    wires = []
    for wire in BALANCE_WIRES:
        loops = (loop_at_ratio(wire, ratio, **change) for change in ({}, without, other_spool(wire)))
        shipped, alone, other = (f"{100.0 * loop.signed_gap:+.2f}" for loop in loops)
        wires.append(f"of the {title(wire)} from {shipped} to {alone} and {other} %")
    return (
        f"At a force ratio of {ratio:.2f}, taking the R-phase out and taking the other wire's temperatures bring the "
        f"signed gap {', '.join(wires)}."
    )


def balance_tables() -> str:
    """Return a table for each wire of what parts its branches."""
    return "\n\n".join(f"{title(wire)}:\n\n{balance_table(balances(wire))}" for wire in BALANCE_WIRES)


def title(wire: str) -> str:
    """Return a wire's name as the page has it."""
    return f"{wire.removeprefix('paper-').removesuffix('um')} µm wire"


def header(first: str) -> list[str]:
    """Return the heads of a table over force ratio."""
    return [first, *(f"{ratio:.2f}" for ratio in FORCE_RATIOS)]


def balance_table(rows: Sequence[Balance]) -> str:
    """Return signed gap, distance in temperature and every part of the difference in resistance, over force ratio."""
    lines: list[tuple[str, Callable[[Balance], str]]] = [
        ("strain gap (Eq. 2), %", lambda row: f"{100.0 * row.loop.strain_gap:.2f}"),
        ("with its sign, heating less cooling, %", lambda row: f"{100.0 * row.loop.signed_gap:+.2f}"),
        ("heating is hotter by, K", lambda row: f"{row.hotter_k:.1f}"),
        ("temperature, mohm", lambda row: f"{1e3 * row.hotter:+.0f}"),
        ("R-phase in place of austenite, mohm", lambda row: f"{1e3 * row.r_phase:+.0f}"),
        ("martensite fraction and geometry, mohm", lambda row: f"{1e3 * row.small:+.0f}"),
        ("all together, mohm", lambda row: f"{1e3 * row.whole:+.0f}"),
    ]
    return table(header("force ratio"), [[words, *(of(row) for row in rows)] for words, of in lines])


def temperature_text(found: dict[str, list[Balance]]) -> str:
    """Return what temperature makes with published and with the shipped coefficients."""
    alloy = load_alloy("flexinol").values()
    austenite, martensite = published_coefficients()
    ours = ", ".join(
        f"{1e4 * alloy[f'{phase}_resistivity_per_k']:+.2f}e-4 /K ({words})"
        for phase, words in zip(PHASES, ("austenite", "R-phase", "martensite"), strict=True)
    )
    published, shipped = [], []
    for wire, rows in found.items():
        published.append(f"{span(rows, lambda row: row.published_hotter)} in the {title(wire)}")
        shipped.append(f"{span(rows, lambda row: row.hotter)}")
    return (
        f"With the published {1e4 * austenite:.0f}e-4 /K of austenite and {1e4 * martensite:.0f}e-4 /K of martensite, "
        f"R-phase counted as austenite, and the {measured_distance_k():.1f} K between the branches of the isobars "
        f"(median of five stresses), this would be {' and '.join(published)}, nearly the same at every load. "
        f"The shipped alloy has {ours}, and branches that come nearer with load: {' and '.join(shipped)}."
    )


def span(rows: Sequence[Balance], part: Callable[[Balance], float]) -> str:
    """Return the range of a part over the force ratios, in milliohm and of the range of resistance."""
    ohm = [part(row) for row in rows]
    percent = [100.0 * part(row) / row.range_ohm for row in rows]
    return (
        f"{1e3 * min(ohm):+.0f} to {1e3 * max(ohm):+.0f} mohm ({min(percent):.1f} to {max(percent):.1f} % of the range)"
    )


def r_phase_text() -> str:
    """Return where the shipped alloy's R-phase is in balance without load, and where it is published to be."""
    published = published_ranges().parameters["r_phase_temperature_k"]
    ours = load_alloy("flexinol").values()["r_phase_temperature_k"]
    low, high = (each - ZERO_DEGC_K for each in (published.low, published.high))
    side = "outside" if published.excess(ours) else "inside"
    return (
        f"Without load the shipped alloy's R-phase is in balance with austenite at {ours - ZERO_DEGC_K:.0f} °C, {side} "
        f"the {low:.0f} to {high:.0f} °C published for binary NiTi."
    )


def barrier_table() -> str:
    """Return half the distance of the branches over stress: the shipped alloy's barrier next to the isobars."""
    measured = measured_distances_k()
    rows = [
        ["shipped", *(f"{half_hysteresis_k(mpa):.1f}" for mpa in STRESSES_MPA)],
        ["measured isobars", *(f"{0.5 * measured[mpa]:.1f}" for mpa in STRESSES_MPA)],
    ]
    return table(["half the hysteresis, K", *(f"{mpa:g} MPa" for mpa in STRESSES_MPA)], rows)


def changes_table() -> str:
    """Return the signed gap over force ratio of the shipped wires and of wires that differ from them in one thing."""
    places = [(wire, ratio) for wire in BALANCE_WIRES for ratio in SHOWN_RATIOS]
    changes = {words: dict.fromkeys(BALANCE_WIRES, changed) for words, changed in changed_wires().items()}
    changes["temperatures of the other wire"] = {wire: other_spool(wire) for wire in BALANCE_WIRES}
    rows = [
        [words, *(f"{100.0 * loop_at_ratio(wire, ratio, **changed[wire]).signed_gap:+.2f}" for wire, ratio in places)]
        for words, changed in changes.items()
    ]
    heads = [f"{title(wire).removesuffix(' wire')}, {ratio:.2f}" for wire, ratio in places]
    return table(["signed gap, %, at force ratio", *heads], rows)
