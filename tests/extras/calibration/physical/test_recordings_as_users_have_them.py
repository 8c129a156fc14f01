"""What a recording is taken for, what is worked out of it, and what is refused, in one line that names it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from found_wires import RECORDINGS, TRUTH, found
from made_wires import BENCH, candidates, driven, slow_sine
from numpy.typing import NDArray

from musclewire.errors import CallerError, RecordingError
from musclewire.extras.calibration import calibrate
from musclewire.extras.calibration._physical.advice import proposed
from musclewire.extras.calibration._physical.driven import DrivenObservation
from musclewire.extras.calibration._physical.observations import Observation, compare, even_clock
from musclewire.extras.calibration._physical.posterior import PosteriorProblem
from musclewire.extras.calibration._physical.recording_kinds import observable_parameters, observations_of, start_of
from musclewire.parameters import load_priors
from musclewire.signals import Recording

Array = NDArray[np.float64]
LOOP = RECORDINGS["loop"]


def observed(recording: Recording, **bench: float) -> Observation:
    return observations_of({"mine.csv": recording}, bench)[0][0]


def residuals_at_truth(recording: Recording, **bench: float) -> dict[str, Array]:
    pairs = compare(observed(recording, **bench).refined(), TRUTH)
    return {pair.channel.name: pair.predicted - pair.channel.measured for pair in pairs}


def only(recording: Recording, *names: str, **changed: Array) -> Recording:
    columns = {name: recording[name] for name in names} | changed
    return Recording(columns, recording.metadata)


def without(recording: Recording, *keys: str) -> Recording:
    return Recording(recording.columns, {key: item for key, item in recording.metadata.items() if key not in keys})


def test_the_wire_that_made_a_recording_explains_it_to_its_noise() -> None:
    found = residuals_at_truth(LOOP)
    assert set(found) == {"resistance", "strain", "force"}
    for name, noise in (("strain", 2e-6 / 0.07), ("force", 4e-3)):
        assert np.std(found[name]) == pytest.approx(noise, rel=0.35)
        assert abs(np.mean(found[name])) < noise
    # Resistance is told well only where a current flows, in the middle of the loop.
    hot = found["resistance"][80:160]
    assert np.std(hot) < 0.02
    assert abs(np.mean(hot)) < 0.005


def test_voltage_and_current_without_a_shunt_are_the_same_wire() -> None:
    shunted = only(LOOP, "time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m")
    bare = without(
        only(LOOP, "time_s", "wire_voltage_v", "displacement_m", wire_current_a=LOOP["shunt_voltage_v"]),
        "shunt_resistance_ohm",
    )
    for name, difference in residuals_at_truth(bare).items():
        assert np.allclose(difference, residuals_at_truth(shunted)[name], atol=2e-3), name


def test_a_command_that_is_not_what_came_out_is_not_believed() -> None:
    halved = LOOP.with_columns(drive_voltage_v=0.5 * LOOP["drive_voltage_v"])
    assert np.std(residuals_at_truth(halved)["strain"]) < 1e-4


def test_a_load_cell_that_was_tared_is_understood() -> None:
    tared = LOOP.with_columns(force_n=LOOP["force_n"] - 1.9)
    assert np.std(residuals_at_truth(tared)["force"]) < 6e-3


def test_the_load_is_read_off_force_and_displacement() -> None:
    whole = driven(TRUTH, slow_sine(3.6, 30.0), keep=("force_n",))
    assert np.ptp(whole["displacement_m"]) > 2e-3, "friction tilts the line the more, the less the wire moves"
    silent = without(whole, "pretension_n", "spring_stiffness_n_per_m")
    bench = observed(silent).bench  # type: ignore[attr-defined]
    # Friction widens the line to a narrow loop.
    assert bench["spring_stiffness_n_per_m"] == pytest.approx(588.6, rel=0.03)
    assert bench["pretension_n"] == pytest.approx(1.9, abs=0.06)


def test_what_the_user_says_counts_before_what_the_recording_says() -> None:
    bench = observed(LOOP, pretension_n=2.5, legs=2.0).bench  # type: ignore[attr-defined]
    assert bench["pretension_n"] == 2.5


def test_an_uneven_clock_is_laid_on_an_even_one() -> None:
    time_s = np.array([0.0, 0.1, 0.2, 0.35, 0.4, 0.5])
    rows, period_s = even_clock(time_s)
    assert period_s == pytest.approx(0.1)
    assert rows.tolist() == [0, 1, 2, 3, 4, 5]
    rows, period_s = even_clock(np.linspace(3.0, 4.0, 11))
    assert (rows.size, period_s) == (11, pytest.approx(0.1))


def test_samples_closer_than_a_step_become_one_and_tell_the_same() -> None:
    often = 100
    fast = Recording(
        {
            "time_s": 5e-4 * np.arange(1, often * len(LOOP) + 1),
            **{name: np.repeat(LOOP[name], often) for name in ("drive_voltage_v", "wire_voltage_v", "shunt_voltage_v")},
            "displacement_m": np.repeat(LOOP["displacement_m"], often),
        },
        LOOP.metadata,
    )
    observation = observed(fast)
    assert observation.bench["sample_period_s"] == pytest.approx(2e-3)  # type: ignore[attr-defined]
    assert np.std(residuals_at_truth(fast)["strain"]) < 5e-4


def test_isobars_are_understood_in_elongation_and_in_contraction() -> None:
    found = RECORDINGS["isobars"]
    turned = found.with_columns(reference_strain=-found["reference_strain"])
    for recording, sign in ((found, "elongation"), (turned, "contraction")):
        observations, notes = observations_of({"mine.txt": recording})
        assert f"strain of isobars: positive in {sign}" in notes
        for pair in compare(observations[0], TRUTH):
            assert np.std(pair.predicted - pair.channel.measured) < 1e-4


def test_under_next_to_no_load_the_other_isobars_tell_the_sign() -> None:
    """There is thermal expansion only, and strain in elongation rises with temperature."""
    light = Recording(
        {
            "wire_temperature_k": (kelvin := np.linspace(295.0, 400.0, 60)),
            "reference_strain": 1e-5 * (kelvin - 295.0),
            "stress_pa": np.full(60, 2e6),
        }
    )
    _, notes = observations_of({"light": light, "others": RECORDINGS["isobars"]})
    assert "strain of isobars: positive in elongation" in notes


def test_what_recordings_can_tell_follows_from_what_they_are() -> None:
    names = {
        kind: set(observable_parameters(load_priors(), observations_of({"a": recording})[0]))
        for kind, recording in (("loop", LOOP), ("isobars", RECORDINGS["isobars"]), ("cooling", RECORDINGS["cooling"]))
    }
    assert names["loop"] == set(candidates().names)
    assert "martensite_resistivity_ohm_m" not in names["isobars"] | names["cooling"]
    assert {"latent_heat_j_per_kg", "convection_factor"} <= names["cooling"] - names["isobars"]
    assert "guide_friction_n" in names["cooling"] - names["isobars"]


def test_the_wire_started_from_has_the_diameter_of_the_recordings() -> None:
    thick = LOOP.with_metadata(wire_diameter_m=200e-6)
    start, notes = start_of({"a": thick}, "paper-100um", {})
    assert start.wire.diameter_m.value == 200e-6
    assert start.wire.maximum_force_n.value == pytest.approx(4.0 * 4.601)
    assert notes == []
    assert start_of({"a": without(LOOP, "wire_diameter_m")}, "paper-100um", {})[1][0].startswith("assumed: 100 um wire")
    with pytest.raises(CallerError, match="calibrate one wire at a time"):
        start_of({"a": thick, "b": LOOP}, "paper-100um", {})


def test_a_wide_step_of_the_simulation_is_as_good_on_the_whole() -> None:
    coarse = observed(LOOP)
    assert isinstance(coarse, DrivenObservation)
    for one, other in zip(compare(coarse, TRUTH), compare(coarse.refined(), TRUTH), strict=True):
        assert np.all(np.abs(one.predicted - other.predicted) < 3.0 * one.channel.uncertainty)


def isobar(temperature_k: Array, strain: Array, stress_pa: Array) -> Recording:
    return Recording({"wire_temperature_k": temperature_k, "reference_strain": strain, "stress_pa": stress_pa})


WARMING_K, RISING, STEADY_PA = np.linspace(300.0, 400.0, 40), np.linspace(0.0, 0.04, 40), np.full(40, 1e8)


REFUSED: dict[str, tuple[Callable[[Recording], Recording], str]] = {
    "a printed loop": (
        lambda _: Recording(
            {"resistance_ohm": [17.0, 16.0], "strain_heating": [0.0, 0.01], "strain_cooling": [0.0, 0.02]}
        ),
        "without drive and clock",
    ),
    "a wire that was never heated": (
        lambda loop: loop.with_columns(
            dict.fromkeys(("wire_voltage_v", "shunt_voltage_v", "drive_voltage_v"), 0.0 * loop["time_s"])
        ),
        "0 V throughout",
    ),
    "no current": (lambda loop: loop.with_columns(shunt_voltage_v=0.0 * loop["time_s"]), "no current"),
    "noise only": (
        lambda loop: loop.with_columns(displacement_m=2e-6 * np.random.default_rng(1).standard_normal(len(loop))),
        "no transformation",
    ),
    "strain of the wrong sign": (
        lambda loop: loop.with_columns(displacement_m=-loop["displacement_m"]),
        "strain of the wrong sign",
    ),
    "strain from another zero": (
        lambda loop: loop.with_columns(displacement_m=loop["displacement_m"] + 1e-3),
        "take off what it reads cold",
    ),
    "millivolts taken for volts": (
        lambda loop: loop.with_columns(wire_voltage_v=1e-3 * loop["wire_voltage_v"]),
        "check units, length and diameter",
    ),
    "ten rows": (lambda loop: loop.between(0, 10), "has 10 rows"),
    "no load": (
        lambda loop: without(
            only(loop, "time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m"), "pretension_n"
        ),
        "the load is not known: give pretension_n",
    ),
    "no length": (lambda loop: without(loop, "wire_length_m"), "the wire's length is not known"),
    "a command without a shunt": (
        lambda loop: without(only(loop, "time_s", "drive_voltage_v", "displacement_m"), "shunt_resistance_ohm"),
        "the shunt is not known",
    ),
    "a constant temperature": (lambda _: isobar(0.0 * WARMING_K + 300.0, RISING, STEADY_PA), "changes by 0 K"),
    "isobars that show nothing": (lambda _: isobar(WARMING_K, 0.0 * RISING, STEADY_PA), "nothing transforms between"),
    "compression": (lambda _: isobar(WARMING_K, RISING, -STEADY_PA), "it must be tension"),
    "a stress that rises along": (lambda _: isobar(WARMING_K, RISING, 75e8 * RISING), "at least 20 points at one"),
    "a cooling curve that does not cool": (
        lambda loop: only(loop, "time_s", wire_temperature_k=np.full(len(loop), 300.0)),
        "its temperature falls by 0 K only",
    ),
    "a cooling curve without a temperature": (
        lambda loop: only(loop, "time_s", "displacement_m"),
        "give bench={'start_temperature_k'",
    ),
    "a clock and nothing else": (lambda loop: only(loop, "time_s"), "there is nothing to compare"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_constrain_anything_is_refused_by_name_in_one_line(name: str) -> None:
    change, words = REFUSED[name]
    with pytest.raises((RecordingError, CallerError)) as caught:
        calibrate({"mine.csv": change(LOOP)})
    message = str(caught.value)
    assert message.startswith("mine.csv: ")
    assert words in message


@pytest.mark.parametrize(
    ("bench", "words"),
    [
        ({"pretention_n": 1.9}, "did you mean 'pretension_n'"),
        ({"pretension_n": "1.9"}, "pretension_n: '1.9' has no unit"),
        ({"pretension_n": -1.0}, "it must be 0 or more"),
        ({"legs": float("nan")}, "give a finite number"),
    ],
)
def test_a_wrong_number_of_the_bench_is_refused(bench: dict[str, float | str], words: str) -> None:
    with pytest.raises(CallerError, match=words):
        calibrate(LOOP, bench=bench)


def test_a_bench_may_be_said_with_units() -> None:
    """The same error as in SI, which is that the wire is impossibly long for its resistance."""
    for long in ("100 cm", 1.0):
        with pytest.raises(RecordingError, match="over 1000 mm of 100 um wire is a resistivity"):
            calibrate(without(LOOP, "wire_length_m"), bench={"wire_length_m": long, "legs": 2.0})
    assert BENCH["wire_length_m"] == 0.14


def test_a_recording_of_two_wires_is_not_taken_for_one_of_one() -> None:
    both = LOOP.with_metadata({"wires": 2, "load": "spring, parallel wire"})
    with pytest.raises(RecordingError, match=r"2 wires made this recording \(spring, parallel wire\)"):
        observed(both)


def test_nobody_is_told_to_pull_a_wire_apart() -> None:
    """Twice 1.9 N and the spring are more than the 4.601 N of this wire; twice 1.0 N are not."""
    gentle = replace(found("loop"), problem=problem_of(driven(TRUTH, slow_sine(), bench={"pretension_n": 1.0})))
    for calibration, offered in ((found("loop"), False), (gentle, True)):
        keys = {key for key, _ in proposed(calibration)}
        assert ("twice_pretension" in keys) is offered
        assert "half_pretension" in keys


def problem_of(recording: Recording) -> PosteriorProblem:
    return PosteriorProblem(found("loop").problem.candidates, observations_of({"loop": recording})[0])
