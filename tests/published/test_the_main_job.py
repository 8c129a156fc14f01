"""The demo against what the paper prints (sections II and III, Table 2), and the report it leaves."""

from __future__ import annotations

import re
from typing import Any

import pytest
from markupsafe import escape
from tests.published.page_parts import Outside

from musclewire.controllers import FuzzyPidSettings, staircase
from musclewire.experiment import characterize, control, control_metrics, determined
from musclewire.files import read_recording
from musclewire.identify import fit
from musclewire.parameters import load_alloy, load_bench, load_wire, read_published
from musclewire.rigs import open_rig
from musclewire.sensing import load_model

PAPER = read_published("lan_fan_2010")
PRINTED_PCT = [*PAPER["table2"]["mae_rise_pct"], *PAPER["table2"]["mae_return_pct"]]


def test_the_strain_gap_is_the_papers(demo: dict[str, Any]) -> None:
    # The bar of the main job: within 0.8 of the printed 1.2172 %.
    assert demo["strain_gap_pct"] == pytest.approx(PAPER["loop_100um"]["strain_gap_pct"], abs=0.8)


def test_the_first_screen_has_no_warning_and_the_report_has_those_of_the_sweep(demo: dict[str, Any]) -> None:
    screen = (demo["folder"] / "screen.txt").read_text("utf-8")
    assert "warning" not in screen, screen
    assert any(text.startswith("pretension 2.7 N") for text in demo["warnings"])
    assert all(escape(text) in demo["page"] for text in demo["warnings"])


def test_the_resistances_at_b_and_c_are_the_papers(demo: dict[str, Any]) -> None:
    # The bar of the main job: within 0.06 ohm of the printed 15.1526 and 17.4945 ohm.
    assert demo["resistance_min_ohm"] == pytest.approx(PAPER["loop_100um"]["resistance_min_ohm"], abs=0.06)
    assert demo["resistance_max_ohm"] == pytest.approx(PAPER["loop_100um"]["resistance_max_ohm"], abs=0.06)


def test_the_staircase_is_followed_as_closely_as_the_paper_followed_it(demo: dict[str, Any]) -> None:
    assert [(step["target_pct"], step["direction"]) for step in demo["steps"]] == [
        *((target, "rise") for target in (1.5, 1.8, 2.1, 2.4, 2.7, 3.0)),
        *((target, "return") for target in (2.7, 2.4, 2.1, 1.8, 1.5)),
    ]
    # The bar of the main job, from cold and without an approach: the paper's own largest and mean after one.
    assert demo["mae_max_pct"] == max(step["mae_pct"] for step in demo["steps"]) <= max(PRINTED_PCT)
    assert demo["mae_mean_pct"] <= sum(PRINTED_PCT) / len(PRINTED_PCT)
    assert demo["steps"][0]["mae_pct"] <= 1.5


def test_the_demo_says_that_the_wire_came_to_the_first_step_from_cold(demo: dict[str, Any]) -> None:
    assert all(step["mae_pct"] == step["mae_approached_pct"] for step in demo["steps"])
    assert demo["mae_mean_pct"] == pytest.approx(sum(step["mae_pct"] for step in demo["steps"]) / len(demo["steps"]))
    assert demo["approach_s"] == 0.0
    assert "no approach" in demo["approach"]
    assert demo["approach"] in demo["page"]


def test_after_the_papers_approach_both_readings_are_stated() -> None:
    with open_rig("simulated", seed=1) as rig:
        metrics = control(rig, fit(characterize(rig)), controller="fuzzy-pid").metrics
    first, *others = metrics.steps
    assert all(step.mae_pct == step.mae_approached_pct for step in others)
    # By the paper's loop the wire is not there one second after it was asked from rest: it is first heated.
    assert determined(first.mae_pct, "a step") > 5.0 * determined(first.mae_approached_pct, "a step")
    assert metrics.mae_max_pct == first.mae_pct
    assert metrics.approach_s == 12.0
    assert "12 s later" in metrics.approach
    # The bar of the paper's loop: largest step MAE at most 3.5 %, mean at most 1.7 %, after the approach.
    assert determined(metrics.mae_max_approached_pct, "the largest") <= 3.5
    assert determined(metrics.mae_mean_approached_pct, "the mean") <= 1.7


def test_the_recording_of_the_staircase_gives_both_readings_again(demo: dict[str, Any]) -> None:
    """Older recordings state as much: they have had their approach in their metadata from the start."""
    again = control_metrics(read_recording(demo["folder"] / "staircase.h5"), "strain", staircase())
    assert [step.mae_pct for step in again.steps] == [step["mae_pct"] for step in demo["steps"]]
    assert [step.mae_approached_pct for step in again.steps] == [step["mae_approached_pct"] for step in demo["steps"]]
    assert again.approach == demo["approach"]


@pytest.mark.parametrize("seed", [2, 3, 4, 5])
def test_other_noise_gives_the_same_picture(seed: int) -> None:
    with open_rig("simulated", seed=seed) as rig:
        model = fit(characterize(rig))
        metrics = control(rig, model).metrics
    assert 100 * model.strain_gap == pytest.approx(PAPER["loop_100um"]["strain_gap_pct"], abs=0.8)
    assert determined(metrics.mae_max_pct, "the largest") <= max(PRINTED_PCT)
    assert determined(metrics.mae_mean_pct, "the mean") <= sum(PRINTED_PCT) / len(PRINTED_PCT)


def test_one_reading_of_the_gains_serves_another_wire_too() -> None:
    # The same input scale and gain ranges on the 125 um wire, at its printed pretension of the closest loop. What the
    # controller senses is held as on the main job; how true that is, is for the loop's gap to say, not for the gains.
    with open_rig("simulated", wire="paper-125um", pretension_n=4.67) as rig:
        metrics = control(rig, fit(characterize(rig)), staircase(0.012, 0.027), controller="fuzzy-pid").metrics
    tracking = [determined(step.tracking_mae_approached_pct, "a step") for step in metrics.steps]
    assert max(tracking) <= 3.5
    assert sum(tracking) / len(tracking) <= 1.7


@pytest.mark.parametrize("pretension_n", [1.9, 3.22, 4.67])
def test_the_loop_holds_what_it_senses_on_another_wire_whatever_its_gap(pretension_n: float) -> None:
    with open_rig("simulated", wire="paper-125um", pretension_n=pretension_n) as rig:
        metrics = control(rig, fit(characterize(rig)), staircase(0.012, 0.027), controller="fuzzy-pid").metrics
    tracking = [determined(step.tracking_mae_approached_pct, "a step") for step in metrics.steps]
    assert sum(tracking) / len(tracking) <= 1.7


def test_read_literally_the_printed_gains_do_not_hold_the_steps() -> None:
    """Why an input scale is needed at all: volts a sample without one leave the steps far behind."""
    with open_rig("simulated") as rig:
        metrics = control(rig, fit(characterize(rig)), settings=FuzzyPidSettings(input_scale=1.0)).metrics
    assert metrics.mae_max_approached_pct is not None
    assert metrics.mae_max_approached_pct > 10.0


def test_the_demo_states_its_numerics_and_repeats_to_the_bit(demo: dict[str, Any]) -> None:
    assert demo["time_step_s"] == 0.0
    with open_rig("simulated", seed=demo["seed"]) as rig:
        loop = characterize(rig, amplitude_v=3.2)
    written = read_recording(demo["folder"] / "loop-3.2V.h5")
    for name in written.names:
        assert (written[name] == loop[name]).all()


def test_minor_loops_lie_inside_the_major_loop_in_order(demo: dict[str, Any]) -> None:
    strokes = [
        read_recording(demo["folder"] / f"loop-{volts}V.h5")["displacement_m"].max() for volts in (3.2, 2.9, 2.75)
    ]
    assert strokes[0] > 1.1 * strokes[1] > 1.2 * strokes[2] > 0.0002


def test_the_model_the_demo_leaves_is_the_one_it_used(demo: dict[str, Any]) -> None:
    model = load_model(demo["folder"] / "model.json")
    assert model.order == PAPER["loop_100um"]["polynomial_order"]
    assert model.resistance_min_ohm == demo["resistance_min_ohm"]
    low, high = model.quantity_min, model.quantity_max
    assert low < 0.015 < 0.030 < high


def test_the_report_stands_alone(demo: dict[str, Any]) -> None:
    page = Outside()
    page.feed(demo["page"])
    assert page.fetched == []
    assert "script" not in page.tags
    assert page.tags.count("svg") == 8  # five figures, three of them drawn for a phone too
    assert "@import" not in demo["page"]
    assert re.search(r"url\((?!#)", demo["page"]) is None


def test_the_report_shows_every_step_beside_the_papers(demo: dict[str, Any]) -> None:
    for step in demo["steps"]:
        assert f"<td>{step['mae_pct']:.3f}</td>" in demo["page"]
        assert f"<td>{step['mae_approached_pct']:.3f}</td>" in demo["page"]
    for printed in (*PAPER["table2"]["mae_rise_pct"], *PAPER["table2"]["mae_return_pct"]):
        assert f"<td>{printed:.3f}</td>" in demo["page"]


def test_the_report_names_every_assumed_parameter(demo: dict[str, Any]) -> None:
    wire = load_wire("paper-100um")
    section = demo["page"].split('id="assumed"')[1].split("<details>")[0]
    assumed = [
        name
        for group in (load_alloy(wire.alloy), wire, load_bench("paper"))
        for name, item in group.items()
        if item.kind == "assumed"
    ]
    assert len(assumed) > 8
    for name in assumed:
        assert f"<td>{name}</td>" in section
