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
    text_difference,
)
from checks.same_samples import JOBS, with_needed

TOLERANCE = 1e-12
SAMPLES = np.linspace(290.0, 410.0, 25)
RESULT = {"rms_pct": 0.83, "settled": True, "health": None, "gains": [0.1, 0.2], "warnings": ["pulls with 203 MPa"]}


def one_ulp_more(values: np.ndarray, index: int) -> np.ndarray:
    changed = values.copy()
    changed[index] = np.nextafter(changed[index], np.inf)
    return changed


def test_one_ulp_of_one_sample_is_found_without_a_tolerance_and_passes_with_one() -> None:
    before, after = {"wire_temperature_k": SAMPLES}, {"wire_temperature_k": one_ulp_more(SAMPLES, 3)}
    (line,) = column_differences(before, after)
    assert line.startswith("wire_temperature_k differs in 1 of 25 samples, by up to 4.7e-16 of its range")
    assert column_differences(before, after, TOLERANCE) == []


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


def test_no_tolerance_is_wide_enough_where_only_one_has_a_number_a_column_or_this_length() -> None:
    missing = np.where(np.arange(25) == 7, np.nan, SAMPLES)
    assert column_differences({"a": missing}, {"a": missing.copy()}) == []
    before = {"a": SAMPLES, "b": SAMPLES, "c": SAMPLES}
    found = column_differences(before, {"a": missing, "b": SAMPLES[1:], "d": SAMPLES}, 1e300)
    assert [line.split()[0] for line in found] == ["a", "b", "column", "column"]


@pytest.mark.parametrize(
    "change", [{"settled": 1}, {"health": 0.0}, {"gains": [0.1]}, {"gains": [0.1, 0.4]}, {"more": 1}], ids=str
)
def test_a_result_may_differ_in_the_last_digits_of_its_numbers_alone(change: dict[str, Any]) -> None:
    after = {**RESULT, "rms_pct": float(np.nextafter(0.83, 1.0)), "warnings": ["203 MPa of pull"]}
    assert len(fact_differences(RESULT, after)) == 1
    assert fact_differences(RESULT, after, TOLERANCE) == []
    assert len(fact_differences(RESULT, {**after, **change}, TOLERANCE)) == 1


def test_times_by_the_wall_clock_and_what_names_the_program_do_not_count_and_those_of_the_simulation_do() -> None:
    before = {"wall_s": 4.1, "compute_us": {"p50": 21.5}, "software_version": "0.1.0", "fingerprint": "3cda"}
    before["checksum"] = "691c"  # of a file with a date
    assert fact_differences([before], [dict.fromkeys(before, "something else")]) == []
    assert column_differences({"latency_us": SAMPLES}, {"latency_us": SAMPLES + 1.0}) == []
    for name in ("time_s", "dead_time_s", "compute_share", "wall_m"):
        assert len(fact_differences({name: 1.0}, {name: 2.0})) == 1
        assert len(column_differences({name: SAMPLES}, {name: SAMPLES + 1.0})) == 1


def test_texts_are_equal_but_for_versions_dates_paths_comments_and_with_a_tolerance_last_digits() -> None:
    before = "/* Written by musclewire 0.1.0 */\n#define MW_KP 0.0979361\n/tmp/a.h5, 2026-11-23T14:32:23+00:00.\n"
    other = "/* Written by musclewire 0.2.0 */\n#define MW_KP 0.0979361\n/home/b.h5, 2027-01-02T03:04:05+01:00.\n"
    near = before.replace("0.0979361", "0.0979362")
    assert text_difference(before, other) == ""
    assert text_difference(before, near).startswith("differs in 1 of 3 lines")
    assert text_difference(before, near, 1e-5) == ""
    assert text_difference(before, near, 1e-7) != ""
    assert text_difference(before, before.replace("KP", "KD"), 1.0) != ""


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
