"""What counts as a difference between two results, for ``checks/same_samples.py``; no job is run here."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from checks.compared_contents import (
    Contents,
    column_differences,
    content_differences,
    fact_differences,
    masked,
    text_difference,
)
from checks.same_samples import JOBS, with_needed

TOLERANCE = 1e-12
SAMPLES = np.linspace(290.0, 410.0, 25)
WITH_GAP = np.where(np.arange(25) == 7, np.nan, SAMPLES)
RESULT = {
    "rms_pct": 0.83,
    "settled": True,
    "ended": "done",
    "health": None,
    "gains": [0.1, 0.2, 0.3],
    "warnings": ["the wire pulls with 203 MPa (3.19 N), above 172 MPa"],
}


def one_ulp_more(values: np.ndarray, index: int) -> np.ndarray:
    changed = values.copy()
    changed[index] = np.nextafter(changed[index], np.inf)
    return changed


def test_one_ulp_of_one_sample_is_found_without_a_tolerance_and_passes_with_one() -> None:
    before, after = {"wire_temperature_k": SAMPLES}, {"wire_temperature_k": one_ulp_more(SAMPLES, 3)}
    (line,) = column_differences(before, after)
    assert line.startswith("wire_temperature_k differs in 1 of 25 samples, by up to 4.7e-16 of its range")
    assert column_differences(before, after, TOLERANCE) == []
    assert column_differences(before, after, 0.0) == [line]
    for tolerance in (None, 0.0, TOLERANCE):
        assert column_differences({"a": WITH_GAP}, {"a": WITH_GAP.copy()}, tolerance) == []


@pytest.mark.parametrize(
    ("before", "after", "apart"),
    [
        (SAMPLES, SAMPLES + 0.0012, 1e-5),  # of the range of 120, not of values around 350
        (np.full(4, -50.0), np.full(4, -50.0005), 1e-5),  # a constant column has its magnitude
    ],
)
def test_the_tolerance_of_a_column_is_a_fraction_of_its_range(
    before: np.ndarray, after: np.ndarray, apart: float
) -> None:
    assert column_differences({"a": before}, {"a": after}, 1.1 * apart) == []
    assert len(column_differences({"a": before}, {"a": after}, 0.9 * apart)) == 1


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_no_tolerance_is_wide_enough_where_only_one_has_a_number(value: float) -> None:
    after = np.where(np.arange(25) == 7, value, SAMPLES)
    for one, other in ((SAMPLES, after), (after, SAMPLES)):
        assert len(column_differences({"a": one}, {"a": other}, 1e300)) == 1


def test_columns_left_out_of_another_length_or_of_another_type_are_named() -> None:
    before = {"a": SAMPLES, "b": SAMPLES, "c": SAMPLES}
    after: dict[str, np.ndarray] = {"a": SAMPLES[1:], "b": SAMPLES.astype(np.float32), "d": SAMPLES}
    assert column_differences(before, after, 1.0) == [
        "a has (25,) and (24,) samples",
        "b has samples of float64 and float32",
        "column c only in one of the two",
        "column d only in one of the two",
    ]


def test_a_number_of_a_result_is_compared_by_its_magnitude() -> None:
    after = {**RESULT, "rms_pct": float(np.nextafter(0.83, 1.0))}
    assert fact_differences(RESULT, RESULT) == []
    assert fact_differences(RESULT, after) == ["rms_pct differs: 0.83 and 0.8300000000000001"]
    assert fact_differences(RESULT, after, TOLERANCE) == []
    assert fact_differences({"a": 1e-9}, {"a": 1.0001e-9}, 1.1e-4) == []
    assert len(fact_differences({"a": 1e-9}, {"a": 1.0001e-9}, 0.9e-4)) == 1


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"settled": 1}, "settled differs: True and 1"),
        ({"ended": "interrupted"}, "ended differs: 'done' and 'interrupted'"),
        ({"health": 0.0}, "health differs: None and 0.0"),
        ({"gains": [0.1, 0.2]}, "gains[] only in one of the two"),
        ({"gains": [0.1, 0.4, 0.5]}, "gains[] differs in 2 places, first: 0.2 and 0.4"),
        ({"more": 1}, "more only in one of the two"),
    ],
)
def test_a_word_a_missing_value_and_a_number_that_is_far_off_are_found_with_a_tolerance_too(
    change: dict[str, Any], line: str
) -> None:
    assert fact_differences(RESULT, {**RESULT, **change}) == [line]
    assert fact_differences(RESULT, {**RESULT, **change}, TOLERANCE) == [line]


def test_of_a_sentence_only_the_numbers_count() -> None:
    reworded = {**RESULT, "warnings": ["pulling: 203 MPa (3.19 N); allowed: 172 MPa"]}
    renumbered = {**RESULT, "warnings": ["the wire pulls with 204 MPa (3.19 N), above 172 MPa"]}
    assert fact_differences(RESULT, reworded) == []
    assert len(fact_differences(RESULT, renumbered, 1e-3)) == 1
    assert fact_differences(RESULT, renumbered, 1e-2) == []


def test_times_by_the_wall_clock_and_what_names_the_program_do_not_count_and_those_of_the_simulation_do() -> None:
    before = {"wall_s": 4.1, "compute_us": {"p50": 21.5}, "software_version": "0.1.0", "fingerprint": "3cda"}
    assert fact_differences([before], [dict.fromkeys(before, "something else")]) == []
    assert column_differences({"latency_us": SAMPLES}, {"latency_us": SAMPLES + 1.0}) == []
    for name in ("time_s", "dead_time_s", "compute_share", "wall_m"):
        assert len(fact_differences({name: 1.0}, {name: 2.0})) == 1
        assert len(column_differences({name: SAMPLES}, {name: SAMPLES + 1.0})) == 1


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("/* Written by musclewire 0.1.0 (export) */", "/* Written by musclewire 0.2.0.dev1+g12ab (export) */"),
        ("made 2026-11-23T14:32:23+00:00.", "made 2027-01-02T03:04:05.678+01:00."),
        ("{5cb60637-6b75-5493-8adb-db8e16c46856}", "{00000000-6b75-5493-8adb-db8e16c46857}"),
        ("in /tmp/same-1/loop.h5: 3 rows", "in /home/somebody/elsewhere/loop.h5: 3 rows"),
        ("/* as in wire.step,\n * line by line */\nx = 1.0;\n", "/* as in wire._step,\n * too */\nx = 1.0;\n"),
    ],
)
def test_versions_dates_guids_absolute_paths_and_comments_of_c_do_not_count(before: str, after: str) -> None:
    assert text_difference(before, after) == ""


@pytest.mark.parametrize("text", ["588.6 N/m", "../loop/model.json", 'fmiVersion="2.0"', "2010-2", "x = a/b/c;"])
def test_units_relative_paths_and_other_numbers_are_not_masked(text: str) -> None:
    assert masked(text) == text


def test_a_text_is_equal_in_every_character_or_with_a_tolerance_in_all_but_the_last_digits() -> None:
    before = "#define MW_KP 0.0979361\n#define MW_KI 0.06\n"
    near = before.replace("0.0979361", "0.0979362")
    assert text_difference(before, before) == ""
    assert text_difference(before, near).startswith("differs in 1 of 2 lines, first line 1: ")
    assert text_difference(before, near, 1e-5) == ""
    assert text_difference(before, near, 1e-7) != ""
    assert text_difference(before, before.replace("KP", "KD"), 1.0) != ""
    assert text_difference(before, before + "\n", 1.0) == "has 2 and 3 lines"


def test_the_contents_of_two_files_are_compared_in_all_their_parts() -> None:
    before = Contents({"a": SAMPLES}, {"b": 1.0}, {"sources/c.c": "1", "d.xml": "2"})
    after = Contents({"a": one_ulp_more(SAMPLES, 0)}, {"b": 2.0}, {"sources/c.c": "3", "e.xml": "2"})
    assert content_differences(before, before) == []
    found = [" ".join(line.split()[:2]) for line in content_differences(before, after)]
    assert found == ["a differs", "b differs:", "d.xml only", "e.xml only", "sources/c.c differs"]


def test_a_job_brings_those_it_needs_and_they_come_before_it() -> None:
    assert with_needed(["particle-filter"]) == ["loop", "calibrate", "particle-filter"]
    order = list(JOBS)
    for name, job in JOBS.items():
        assert all(order.index(need) < order.index(name) for need in job.needs)
