"""The page of ``musclewire reproduce``: our figures next to the rows they belong to, in one HTML file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from itertools import groupby
from typing import TYPE_CHECKING

from musclewire.extras.paper._page.origin_table import origin_table
from musclewire.extras.paper._page.paper_figures import drawn
from musclewire.extras.paper._page.row_names import row_name
from musclewire.extras.paper._page.row_table import VERDICT_CLASS, numbers, reasons, rows_table
from musclewire.extras.paper._page.row_text import reason_text, seeds_text, verdict_text
from musclewire.extras.paper._reproduce.verdicts import counts_by_origin
from musclewire.pages import NumberCard, cards, page
from musclewire.signals import write_text_whole

if TYPE_CHECKING:
    from pathlib import Path

    from musclewire.extras.paper._reproduce import Reproduction, ReproductionRow

__all__ = ["PARTS", "TITLES", "write_paper_page"]

# Title and text of each subject, in the order of the page.
TITLES: dict[str, tuple[str, str]] = {
    "table1": ("Table 1: the wires", "Forces and diameters were taken over; resistance per metre is simulated."),
    "setup": ("Section 2.1: the setup", "What the main loop was run with, read back from its recording."),
    "eq1": ("Eq. 1: resistance from two voltages", ""),
    "eq2": ("Eq. 2: the gap", ""),
    "eq3": ("Eq. 3: normalised resistance", ""),
    "eq4": ("Eq. 4: polynomials of both branches", ""),
    "eq5": ("Eq. 5: their average", ""),
    "eq6": (
        "Eq. 6: gains within their ranges",
        "Least and largest gain of the steps, and what the rules can reach.",
    ),
    "eq7": ("Eq. 7: the mean absolute error", ""),
    "fig3a": ("Fig. 3(a): strain against voltage", "The major loop, and two of smaller amplitude inside it."),
    "fig3b": ("Fig. 3(b): strain against resistance", "The same loops, and how the strain divides at B."),
    "fig4": (
        "Fig. 4: pretension closes the strain loop (125 µm)",
        'The paper adds that "the strain gap of the largest pretension force is almost zero", and prints 2.702 % for '
        "it: both have a row, the words as the largest distance of the branches.",
    ),
    "fig5": ("Fig. 5: the force loop closes and opens again (125 µm)", ""),
    "fig6a": (
        "Fig. 6(a): strain gap against force ratio",
        "Three diameters at equal fractions of their maximum force. The paper has each gap fall to the right.",
    ),
    "fig6b": ("Fig. 6(b): force gap against force ratio", ""),
    "fig7": (
        "Fig. 7: strain hardly depends on the spring (100 µm, 1.70 N)",
        "The paper prints none of its three stiffnesses; half, one and two times its spring are our choice.",
    ),
    "fig8": ("Fig. 8: force does", ""),
    "fig9": ("Fig. 9: the loop, its polynomials and their average (100 µm, 1.9 N)", ""),
    "table2": (
        "Table 2: strains, required resistances, errors",
        'The text calls it Table 3. Of the errors it says "less than 2 %" but for one; its own table prints 2.000 '
        "for a second.",
    ),
    "fig11": ("Fig. 11: the staircase", "Moved by resistance alone; the displacement sensor only judges."),
    "fig12": ("Fig. 12: the trace of the staircase", ""),
    "fig13a": (
        "Fig. 13(a): distributed against concentrated actuation",
        "The same finger pulled in several ways, each until its beam's stress is used up or it comes no further.",
    ),
    "fig13b": ("Fig. 13(b, c): the finger", "Its printed sizes; all else of the shipped finger is ours."),
    "fig14": (
        "Fig. 14: pretensioner and finger",
        "A serpentine designed for the printed stiffness in the printed envelope, and what it is for.",
    ),
    "eq8": ("Eq. 8: the forces at the connector", ""),
    "fig15": (
        "Fig. 15: the zero of the tendon",
        "Linear Stage 2 is drawn back until the load cell shows that the tendon pulls; the kink is its zero.",
    ),
    "fig16": ("Fig. 16: endpoint against resistance over pretension", ""),
    "fig17": (
        "Fig. 17: displacement gap against pretension",
        "Rows for two spools: the finger's wire as a spool of its own, fitted to the printed gap by two numbers, and "
        "the spool of section III as it is.",
    ),
    "table3": (
        "Table 3: errors of the finger's staircase",
        "The text calls it Table 5. Each step has its own printed number and one tolerance; the worst has its own row.",
    ),
    "fig18": ("Fig. 18: the finger's staircase", "Moved by resistance alone; the laser only judges."),
    "section1": ("Section I: what a wire can do", "Said of slender wires in general, not of the paper's bench."),
    "section5": ("Section V: the conclusions", "What the paper promises for spring and finger."),
    "isobars": (
        "Not in the paper: Flexinol isobars",
        "The same alloy under constant stress, compared with measured loops published elsewhere (Texas A&amp;M). "
        'Rows "held out" are of the two loops that no search has used.',
    ),
}


# What stands together on the page, pictures first.
PARTS: dict[str, tuple[str, ...]] = {
    "Section II: the loop, and what closes it": (
        *("fig3a", "fig3b", "fig4", "fig5", "fig6a", "fig6b", "fig7", "fig8"),
    ),
    "Section III: a wire that senses its own strain": ("fig9", "fig11", "table2", "fig12"),
    "Section IV: a finger": (*("fig13a", "fig13b", "fig14", "eq8", "fig15", "fig16", "fig17", "table3", "fig18"),),
    "Loops measured elsewhere, promises, set-up and equations": (
        *("isobars", "section1", "section5", "table1", "setup", "eq1", "eq2", "eq3", "eq4", "eq5", "eq6", "eq7"),
    ),
}


def write_paper_page(
    result: Reproduction, path: Path, selection: str, on_figure: Callable[[str], None] = lambda _: None
) -> None:
    """Write the page, whole or not at all; ``on_figure`` is called with each subject before it is drawn."""
    subjects = {subject: list(rows) for subject, rows in groupby(result.rows, key=lambda row: row.subject)}
    sections = []
    for title, members in PARTS.items():
        cards_of_part = []
        for subject in (member for member in members if member in subjects):
            on_figure(subject)
            cards_of_part.append(section(subject, subjects[subject], drawn(subject, result.runs)))
        if cards_of_part:
            sections.append(f'<h2 class="part">{title}</h2><div class="columns">{"".join(cards_of_part)}</div>')
    parts = {
        "seeds": seeds_part(result),
        "origins": origin_table(counts_by_origin(result.rows)),
        "cards": cards(counts(result)),
        "links": "".join(
            link(subject, subjects[subject]) for part in PARTS.values() for subject in part if subject in subjects
        ),
        "failing_title": failing_title(result),
        "failing": failing_part(result),
        "sections": "".join(sections),
        "which_seeds": escape(seeds_text(result.seeds)),
        "selection": escape(selection),
    }
    write_text_whole(path, page("musclewire.extras.paper._page", "paper.html", parts))


def seeds_part(result: Reproduction) -> str:
    """Return which seeds the numbers and the figures are of; a warning where it is one alone."""
    if result.single_seed is not None:
        return (
            f'<div class="warning">Every number and figure here is of <b>seed {result.single_seed} alone</b>. Another '
            "seed gives other noise, and near a limit another verdict: without --seed each row is judged by its median "
            "over many.</div>"
        )
    return (
        f'<p class="note">Each number of ours is the <b>median over {len(result.seeds)} seeds</b>: as many runs, each '
        "with other noise of the simulated instruments; beneath it, small, are the 5 and 95 % points of the seeds. "
        "Where a limit is inside the 95 % interval of a median, other seeds could decide otherwise: the row is "
        f"<b>at the bar</b>, and counts as failing. Figures are drawn from seed {result.seeds[0]}.</p>"
    )


def counts(result: Reproduction) -> list[NumberCard]:
    """Return how many rows hold, fail or were repaired."""
    holding = len(result.judged_rows) - len(result.failing)
    reported = len(result.rows) - len(result.judged_rows)
    known = len(result.failing) - len(result.new_failures)
    at_the_bar = sum(row.verdict == "at the bar" for row in result.rows)
    return [
        NumberCard(
            "Rows that hold", f"{holding} of {len(result.judged_rows)}", f"{at_the_bar} at the bar count as failing"
        ),
        NumberCard("Failing, known", str(known), "on the committed list"),
        NumberCard("Failing, new", str(len(result.new_failures)), "not on the list"),
        NumberCard("Repaired", str(len(result.repaired)), "on the list, and hold"),
        *([NumberCard("Reported, not judged", str(reported), "count for no bar")] if reported else []),
        NumberCard("Computed in", f"{result.wall_s:.1f} s", "before drawing"),
    ]


def short_title(subject: str) -> str:
    """Return what stands before the colon of a title."""
    if subject == "isobars":
        return "Isobars"
    return TITLES[subject][0].partition(":")[0]


def link(subject: str, rows: Sequence[ReproductionRow]) -> str:
    """Return the link to a section with a mark for each of its rows."""
    marks = "".join(f'<i class="{VERDICT_CLASS[row.verdict]}"></i>' for row in rows)
    failing = "" if all(row.ok for row in rows) else ' class="failing"'
    return f'<a href="#{subject}"{failing}>{short_title(subject)} <span class="marks">{marks}</span></a>'


def section(subject: str, rows: Sequence[ReproductionRow], figure: str) -> str:
    """Return a section: its figure, how many of its rows hold, the rows, and why they are judged so."""
    title, text = TITLES[subject]
    paragraph = f"<p>{text}</p>" if text else ""
    return (
        f'<section id="{subject}"><h3>{title}</h3>{paragraph}{figure}{score(rows)}{rows_table(rows)}'
        f"{reasons(rows)}</section>"
    )


def score(rows: Sequence[ReproductionRow]) -> str:
    """Return how many rows hold, of those that are judged."""
    judged = [row for row in rows if row.is_judged]
    holding = sum(row.ok for row in judged)
    return f'<p class="score {"holds" if holding == len(judged) else "fails"}">{holding} of {len(judged)} hold</p>'


def failing_title(result: Reproduction) -> str:
    """Return the heading of the summary."""
    count = len(result.failing)
    return (
        "Every row holds" if count == 0 else f"{count} row{'' if count == 1 else 's'} of {len(result.judged_rows)} fail"
    )


def failing_part(result: Reproduction) -> str:
    """Return the failing rows, and those that hold although the list says otherwise."""
    if not result.failing and not result.repaired:
        return "<p>Nothing on this page is outside its tolerance.</p>"
    failing = "".join(failing_row(row) for row in result.failing)
    repaired = "".join(failing_row(row) for row in result.repaired)
    more = (
        f"<details><summary>{len(result.repaired)} hold, and are listed as failing</summary>"
        f'<div class="failures">{repaired}</div></details>'
    )
    return f'<div class="failures">{failing}</div>{more if repaired else ""}'


def failing_row(row: ReproductionRow) -> str:
    """Return a failing row as a small article: where it belongs, what it is, its numbers, and why."""
    return (
        f'<article class="{VERDICT_CLASS[row.verdict]}"><h3><a href="#{row.subject}">{short_title(row.subject)}</a> '
        f"{escape(row_name(row).whole)}</h3><p>{numbers(row)} · <b>{verdict_text(row)}</b></p>"
        f'<p class="reason">{escape(reason_text(row))}</p></article>'
    )
