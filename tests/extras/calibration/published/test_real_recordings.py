"""The study of public recordings: baselines are judged at points they have not seen; what is absent is not tried."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from studies.real_recordings import SOURCES, Points, by_curves, coil_loop, error_pct, pulses, tables, tried
from tests.places import CHECKOUT

HEADER = "cycle,r_hot_ohm,r_base_ohm,p_hot_W,heat_ms,dx_um,detect_ok,clipped,railed"


def test_a_point_is_estimated_by_all_others() -> None:
    random = np.random.default_rng(3)
    read, stroke = random.random(12), random.random(12)
    points = Points(read, stroke, np.arange(12) < 6, np.zeros(12, np.intp))
    found = by_curves(points, read, 1, of_each_branch=True)
    for place in range(12):
        others = [one for one in range(12) if (one < 6) == (place < 6) and one != place]
        assert found[place] == pytest.approx(np.polyval(np.polyfit(read[others], stroke[others], 1), read[place]))


def test_pulses_are_fitted_to_four_of_a_condition_and_judged_by_the_others(tmp_path: Path) -> None:
    watt = (0.5, 1.0, 1.5)
    rows = [f"{cycle},{4.7 - one},4.7,{one},400,{1000 * one},1,0,0" for one in watt for cycle in range(1, 7)]
    rows.append("5,1.0,4.7,9.0,400,9999,1,1,0")  # clipped
    file = tmp_path / "pulses.csv"
    file.write_text("\n".join([HEADER, *rows]), "utf-8")
    points = pulses([file])
    assert points.fitted is not None
    assert (points.fitted.size, points.fitted.sum()) == (18, 12)
    assert points.energy_j == pytest.approx(0.4 * np.repeat(watt, 6))
    assert error_pct(points, by_curves(points, points.energy_j, 1, of_each_branch=False)) == pytest.approx(
        (0, 0), abs=1e-9
    )
    # A mean for all is off by half of the stroke range: one and a half is 100 %.
    assert error_pct(points, np.full(18, 1e-3))[1] == pytest.approx(100.0 / 3.0)


def test_a_meter_that_is_asked_too_often_repeats_itself_and_a_laser_may_count_down(tmp_path: Path) -> None:
    file = tmp_path / "processed.csv"
    rows = ["4.4,nan", *[f"{4.4 - 0.01 * n},{-0.1 * n}" for n in range(21) for _ in range(2)], "4.3,-1.0"]
    file.write_text("\n".join(["rs_raw_ohm,displacement_mm", *rows]), "utf-8")
    points = coil_loop([file])
    assert points.read.size == 22
    assert points.stroke.max() == pytest.approx(2e-3)
    assert points.heating.sum() == 21


def test_a_recording_that_cannot_be_had_is_not_tried(tmp_path: Path) -> None:
    rows = {source.name: tried(source, tmp_path) for source in SOURCES if "pulse" in source.name}
    assert len(rows) == 3
    for row in rows.values():
        assert set(row["files"].values()) == {"not tried"}
        assert "points" not in row


def test_the_page_has_what_the_study_prints(tmp_path: Path) -> None:
    page = (CHECKOUT / "docs" / "explanation" / "real_recordings.md").read_text("utf-8")
    quick = [source for source in SOURCES if "isobars" not in source.name]
    for line in tables([tried(source, tmp_path) for source in quick]).splitlines():
        assert line in page
