"""A wire of the catalogue through characterize, fit, pretension and control by default: no trip, circle or heat."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.command_line import Answer

import musclewire as mw
from musclewire.files import read_recording
from musclewire.identify import reached_in
from musclewire.parameters import ValidityLimits, exceeds

# Pretensions in proportion to the section: what the maker's door has for 0.10 mm, on both legs of the bench's V.
PRETENSION_N = {"0.10": 1.3, "0.15": 2.9, "0.25": 8.1}
NINE = list(itertools.product(PRETENSION_N, (60, 100, 140)))
HOTTEST_K = 413.15

Command = Callable[..., Answer]


def rig_file(folder: Path, diameter_mm: str, length_mm: int) -> Path:
    """Return a rig file that states the wire, its length and its pretension, and nothing else."""
    file = folder / "rig.toml"
    file.write_text(
        f'kind = "simulated"\nwire = "flexinol-{diameter_mm}-lt"\nwire_length = "{length_mm} mm"\n'
        f'pretension = "{PRETENSION_N[diameter_mm]} N"\n',
        "utf-8",
    )
    return file


def hottest_k(rig_path: Path, drive: Callable[..., object]) -> float:
    """Return the true temperature that a run with defaults leads to; a trip raises."""
    with mw.open_rig(rig_path) as rig:
        seen = [0.0]

        def on_sample(_row: object) -> None:
            seen[0] = max(seen[0], rig.device.wire_state.temperature_k)  # type: ignore[attr-defined]  # a simulation

        drive(rig, on_sample=on_sample)
    return seen[0]


def check_from_table_to_loop(folder: Path, musclewire: Command, diameter_mm: str, length_mm: int) -> None:
    """Run the four commands on one wire with their defaults and hold what they say against each other."""
    rig, loop, model, run = (
        rig_file(folder, diameter_mm, length_mm),
        *(folder / name for name in ("a.h5", "m.json", "b.h5")),
    )
    characterized = musclewire("characterize", rig, "-o", loop, "--json")
    assert characterized.code == 0
    fitted = musclewire("fit", loop, "-o", model, "--json")
    assert fitted.code == 0
    swept = musclewire("pretension", rig, "--json")
    controlled = musclewire("control", rig, model, "-o", run, "--json")
    assert controlled.code == 0
    assert controlled.json["ended"] == "done"

    # Heat: none of them asks for less drive, and none for more where there is no room.
    texts = [*characterized.json["warnings"], *fitted.json["warnings"], *swept.json["warnings"]]
    assert not [text for text in texts if " C, above the " in text]
    assert characterized.json["shows_c"] is True
    assert not [text for text in fitted.json["warnings"] if "not complete" in text]
    assert hottest_k(rig, lambda opened, **watch: mw.characterize(opened, **watch)) <= HOTTEST_K
    model_of_file = mw.load_model(model)
    assert (
        hottest_k(rig, lambda opened, **watch: mw.control(opened, model_of_file, mw.staircase(), **watch)) <= HOTTEST_K
    )

    # Pull: what is named is within the vendor's stress in motion, and where that costs a smaller gap, it is said.
    limit_pa = ValidityLimits.stated_in(read_recording(loop).metadata).working_stress_pa
    assert limit_pa is not None
    rows = {row["pretension_n"]: row for row in swept.json["rows"]}
    best = rows[swept.json["best_pretension_n"]]
    assert swept.code == 0
    assert best["within_limit"]
    with mw.open_rig(rig, pretension_n=best["pretension_n"]) as opened:
        at_best = mw.characterize(opened)
    assert not exceeds(reached_in(at_best).largest_stress_pa, limit_pa)
    smaller = [row for row in rows.values() if row["strain_gap_pct"] < best["strain_gap_pct"]]
    assert not [row for row in smaller if row["within_limit"]]
    assert bool(smaller) == ("a smaller gap" in swept.json["advice"])
    if "musclewire pretension" in "".join(fitted.json["warnings"]):
        # The sweep either has a smaller gap to offer, or says what has.
        assert best["strain_gap_pct"] < fitted.json["strain_gap_pct"] or "'filter'" in swept.json["advice"]


@pytest.mark.slow
def test_a_wire_of_the_catalogue_gets_from_its_table_to_a_closed_loop(tmp_path: Path, musclewire: Command) -> None:
    check_from_table_to_loop(tmp_path, musclewire, "0.15", 140)


# Of steps of 6 s the loop is late here, and the ruler is too often beyond the interval of the estimate.
CONTRADICTED = pytest.mark.xfail(strict=True, reason="0.25 mm: control ends with 1, 'late' and 'contradicted'")


@pytest.mark.full
@pytest.mark.parametrize(
    ("diameter_mm", "length_mm"),
    [pytest.param(*wire, marks=[CONTRADICTED] if wire[0] == "0.25" else []) for wire in NINE if wire != ("0.15", 140)],
)
def test_nine_wires_get_from_their_table_to_a_closed_loop(
    tmp_path: Path, musclewire: Command, diameter_mm: str, length_mm: int
) -> None:
    check_from_table_to_loop(tmp_path, musclewire, diameter_mm, length_mm)
