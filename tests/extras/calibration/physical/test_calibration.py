"""Wires drawn from the prior, found again from recordings of them; and advice held against what measuring brings."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from found_wires import RECORDINGS, TRUTH, found
from made_wires import BENCH, isobars
from numpy.typing import NDArray

import musclewire as mw
from musclewire.errors import CallerError
from musclewire.extras.calibration import Calibration, calibrate
from musclewire.parameters import bench_known_with, load_alloy, load_wire
from musclewire.signals import Recording

Array = NDArray[np.float64]


@cache
def advised(*names: str) -> tuple[Any, ...]:
    """What to measure after such a calibration."""
    return mw.next_experiments(found(*names))


def true_number(name: str) -> float:
    return {**TRUTH.alloy, **TRUTH.wire, **TRUTH.bench}[name]


def deviation_of(calibration: Calibration, name: str) -> float:
    return next(item.std / item.prior_std for item in calibration.estimates if item.name == name)


@pytest.mark.parametrize(
    "names",
    [
        ("loop",),
        *(
            pytest.param(names, marks=pytest.mark.slow)
            for names in [("isobars",), ("cooling",), ("loop", "isobars"), ("loop", "cooling")]
        ),
    ],
    ids=" and ".join,
)
def test_the_wire_is_found_again_and_its_intervals_hold_it(names: tuple[str, ...]) -> None:
    """At least four numbers of a wire are told by a loop or by isobars, one by a cooling curve alone.

    The ensemble of grains claimed five for that curve at steps of 1 ms: rounding that it amplified counted as
    information. In steps of 0.1 ms, with 1280 grains, it gave the intervals of the fronts to a hundredth, and one.
    """
    calibration = found(*names)
    assert calibration.holds
    assert calibration.rmse < 1.0
    told = calibration.identifiable
    off = np.array([abs(item.value - true_number(item.name)) / item.std for item in told])
    assert len(told) >= (1 if names == ("cooling",) else 4)
    assert np.mean(off < 1.96) >= 0.9
    assert off.max() < 4.0


EARLY = ("early_fraction", "early_width")


@pytest.mark.slow
@pytest.mark.parametrize("early", [(0.25, 4.0), (0.1, 6.0), (0.15, 3.0)])
def test_isobars_tell_early_grains_apart(early: tuple[float, float]) -> None:
    """A quarter of the grains over 4 spreads, a tenth over 6, a seventh over 3: each is found within its interval."""
    truth = dict(zip(EARLY, early, strict=True))
    recording = isobars(TRUTH._replace(alloy={**TRUTH.alloy, **truth}))
    calibration = calibrate(recording, settings=mw.settings_of_effort("quick"))
    items = {item.name: item for item in calibration.estimates}
    for name, value in truth.items():
        assert items[name].std < 0.8 * items[name].prior_std
        assert abs(items[name].value - value) < 2.5 * items[name].std
    assert items["early_fraction"].identifiable
    assert calibration.alloy.early_fraction.kind == "fitted"


@pytest.mark.slow
def test_isobars_that_end_before_the_early_grains_leave_them_to_their_prior() -> None:
    """They would turn to martensite in colder air than was recorded: the file says that they are assumed."""
    whole = isobars(TRUTH)
    seen = whole["wire_temperature_k"] > TRUTH.alloy["martensite_temperature_k"] + whole["stress_pa"] / 8e6 - 5.0
    hot = Recording({name: values[seen] for name, values in whole.columns.items()}, whole.metadata)
    calibration = calibrate(hot, settings=mw.settings_of_effort("quick"))
    for item in calibration.estimates:
        if item.name in EARLY:
            assert not item.identifiable
            assert abs(item.value - item.prior_mean) < item.prior_std
            assert getattr(calibration.alloy, item.name).kind == "assumed"
            assert "prior" in getattr(calibration.alloy, item.name).source


def log_ratio(calibration: Calibration, above: str, below: str) -> tuple[float, float]:
    """The logarithm of one parameter over another, and its standard deviation (first order)."""
    items = {item.name: item for item in calibration.estimates}
    names = calibration.problem.candidates.names
    one, other = items[above], items[below]
    shares = one.std / one.value, other.std / other.value
    r = calibration.correlation[names.index(above), names.index(below)]
    variance = shares[0] ** 2 + shares[1] ** 2 - 2.0 * r * shares[0] * shares[1]
    return float(np.log(one.value / other.value)), float(np.sqrt(variance))


LATENT_HEAT_WITH_SHIFTS = pytest.mark.xfail(
    strict=True,
    reason="0.128 in the quotient, 0.145 in the latent heat alone: a factor of 0.89 where 0.85 is asked for; the spool "
    "of paper-100um has temperature shifts now",
)


@pytest.mark.slow
@pytest.mark.parametrize(
    "heat", ["specific_heat_j_per_kg_k", pytest.param("latent_heat_j_per_kg", marks=LATENT_HEAT_WITH_SHIFTS)]
)
def test_a_cooling_curve_tells_heat_over_convection_better_than_either(heat: str) -> None:
    value, deviation = log_ratio(found("cooling"), heat, "convection_factor")
    truth = float(np.log(true_number(heat) / true_number("convection_factor")))
    assert abs(value - truth) < 2.5 * deviation
    item = next(item for item in found("cooling").estimates if item.name == heat)
    assert deviation < 0.85 * item.std / item.value


@pytest.mark.slow
def test_a_loop_and_a_cooling_curve_together_tell_convection() -> None:
    both = found("loop", "cooling")
    item = next(item for item in both.estimates if item.name == "convection_factor")
    assert abs(item.value - true_number("convection_factor")) < 2.5 * item.std
    assert item.std < 0.8 * min(
        next(other.std for other in found(name).estimates if other.name == "convection_factor")
        for name in ("loop", "cooling")
    )


@pytest.mark.slow
def test_isobars_bring_what_advice_said_they_would() -> None:
    """Outside check: the advice is computed from a derivative alone, this from measuring and calibrating again."""
    before, after = found("loop"), found("loop", "isobars")
    advice = next(item for item in advised("loop") if item.title.startswith("Isobars"))
    assert len(advice.identifies) >= 4
    promised = {item.name: item for item in after.estimates if item.name in advice.identifies}
    kept = [item for item in promised.values() if item.identifiable]
    assert len(kept) >= 0.75 * len(promised)
    # The advice is linear, and the search ends where rounding takes it: one promise in four may go unkept, none
    # backwards.
    shares = [item.std / item.prior_std / deviation_of(before, name) for name, item in promised.items()]
    assert sum(share < 0.95 for share in shares) >= 0.75 * len(promised)
    assert max(shares) <= 1.0


@pytest.mark.slow
def test_advice_speaks_only_of_what_is_not_told_yet_and_never_of_what_was_measured() -> None:
    for names in (("loop",), ("isobars",), ("loop", "isobars")):
        calibration = found(*names)
        told = {item.name for item in calibration.identifiable}
        advice = advised(*names)
        assert 1 <= len(advice) <= 3
        for item in advice:
            assert not told & set(item.identifies + item.narrows)
            assert not ("isobars" in names and item.title.startswith("Isobars"))
        counts = [len(item.identifies) for item in advice]
        assert counts == sorted(counts, reverse=True)


@pytest.mark.slow
def test_after_isobars_alone_a_loop_with_current_would_tell_resistivities() -> None:
    best = advised("isobars")[0]
    assert best.title == "A slow loop with current"
    assert {"austenite_resistivity_ohm_m", "martensite_resistivity_ohm_m", "convection_factor"} <= set(best.identifies)
    assert set(found("isobars").not_searched) >= {"austenite_resistivity_ohm_m", "convection_factor"}


def test_the_wire_file_is_the_wire_found(tmp_path: Path) -> None:
    calibration = found("loop")
    mw.save_wire(calibration, tmp_path / "mine.toml")
    wire = load_wire(str(tmp_path / "mine.toml"))
    assert wire.values() == calibration.wire.values()
    assert load_alloy(wire.alloy).values() == calibration.alloy.values()
    kinds = {**dict(load_alloy(wire.alloy).items()), **dict(wire.items())}
    for item in calibration.estimates:
        if item.group != "bench":
            assert kinds[item.name].kind == ("fitted" if item.identifiable else "assumed")
    known = {name: item.value for name, item in bench_known_with(str(tmp_path / "mine.toml")).items()}
    assert known.pop("guide_friction_n") == calibration.values.bench["guide_friction_n"]
    assert known == {**BENCH}
    with pytest.raises(CallerError, match=r"a wire is a \.toml file"):
        mw.save_wire(calibration, tmp_path / "mine.json")


def test_a_rig_with_the_wire_found_does_the_loop_that_was_measured(tmp_path: Path) -> None:
    mw.save_wire(found("loop"), tmp_path / "mine.toml")
    drive = RECORDINGS["loop"]["drive_voltage_v"]
    quiet = {"displacement_noise_m": 0.0, "guide_presliding_m": TRUTH.bench["guide_presliding_m"]}
    with mw.open_rig("simulated", wire=str(tmp_path / "mine.toml"), **quiet) as rig:
        moved = np.array([rig.exchange(float(volt)).displacement_m for volt in drive])
    strain_off = (moved - RECORDINGS["loop"]["displacement_m"]) / 0.07
    assert np.sqrt(np.mean(strain_off**2)) < 5e-4


@pytest.mark.slow
def test_it_prints_something_useful_and_plots(tmp_path: Path) -> None:
    calibration = found("loop", "isobars")
    assert "the fit holds" in str(calibration)
    assert "<table>" in calibration._repr_html_()
    assert len(mw.channel_axes(found("loop")).lines) == 2
    mw.write_report(calibration, tmp_path / "mine.html")
    page = (tmp_path / "mine.html").read_text("utf-8")
    assert page.count("<svg") > len(calibration.estimates)
    assert "What to measure next" in page
    with pytest.raises(CallerError, match=r"a report is an \.html file"):
        mw.write_report(calibration, tmp_path / "mine.pdf")


@pytest.mark.slow
def test_what_the_model_cannot_follow_is_said_not_to_hold() -> None:
    """Strain that creeps by half a percent over a loop is nothing this model knows."""
    loop = RECORDINGS["loop"]
    creep = 0.005 * 0.07 * np.sin(8.0 * np.linspace(0.0, np.pi, len(loop)))
    spoilt = loop.with_columns(displacement_m=loop["displacement_m"] + creep * (loop["displacement_m"] > 1e-4))
    calibration = calibrate({"loop": spoilt}, settings=mw.settings_of_effort("quick"))
    assert not calibration.holds
    assert "strain" in {pair.channel.name for _, pair in calibration.not_followed}
    assert calibration.excess_variance > 1.0
    assert "the fit does not hold" in str(calibration)


@pytest.mark.slow
def test_one_recording_may_come_bare_and_several_as_a_list() -> None:
    one = calibrate(RECORDINGS["isobars"], settings=mw.settings_of_effort("quick"))
    same = calibrate([RECORDINGS["isobars"]], settings=mw.settings_of_effort("quick"))
    assert np.array_equal(one.search_result.coordinates, same.search_result.coordinates)
    with pytest.raises(CallerError, match="no recording"):
        calibrate([])
    assert isinstance(RECORDINGS["loop"], Recording)
