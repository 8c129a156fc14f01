"""Figures have the width of their style, whatever is drawn, and a wrong name suggests the right one."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingError
from musclewire.figures import SubstituteFontWarning, figure_style, figure_style_names
from musclewire.signals import PLOTS, Recording, usual_plot

TIME_S = np.linspace(0.0, 10.0, 201)
STRAIN = 0.02 + 0.01 * np.sin(TIME_S)
RUN = Recording(
    {"time_s": TIME_S, "drive_voltage_v": 2.0 + STRAIN, "target_strain": STRAIN, "estimated_strain": STRAIN + 1e-4,
     "reference_strain": STRAIN - 1e-4},
    {},
)  # fmt: skip
INCH_MM = 25.4


@pytest.mark.parametrize("style", figure_style_names())
@pytest.mark.parametrize("kind", ["control", "time"])
def test_a_figure_is_as_wide_as_its_style_says(kind: str, style: str) -> None:
    figure = RUN.plot(kind, style=style)
    width_in, height_in = figure.get_size_inches()
    assert width_in * INCH_MM == pytest.approx(figure_style(style).width_mm)
    limit = figure_style(style).max_height_mm
    assert not limit or height_in * INCH_MM <= limit + 1e-9


def test_what_was_followed_is_what_is_drawn() -> None:
    strain, errors, drive = RUN.plot().axes
    lines = {line.get_label(): line.get_ydata() for line in strain.get_lines()}
    assert np.allclose(lines["target"], 100.0 * STRAIN)
    assert np.allclose(lines["estimated"], 100.0 * (STRAIN + 1e-4))
    off = {line.get_label(): line.get_ydata() for line in errors.get_lines()}
    assert np.allclose(off["estimated - measured"], 0.02)
    assert drive.get_ylabel() == "drive [V]"


def test_the_kind_follows_from_the_columns() -> None:
    assert usual_plot(RUN.names) == "control"
    assert usual_plot(("time_s", "wire_resistance_ohm", "displacement_m")) == "loop"
    assert usual_plot(("time_s", "wire_voltage_v", "shunt_voltage_v", "reference_strain")) == "loop"
    assert usual_plot(("time_s", "wire_voltage_v")) == "time"


def test_a_wrong_name_suggests_the_nearest() -> None:
    with pytest.raises(CallerError, match="'ieee-single'"):
        figure_style("ieee-singel")
    with pytest.raises(CallerError, match="'loop'"):
        PLOTS.find("lop")


def test_a_run_of_control_needs_a_target() -> None:
    with pytest.raises(RecordingError, match="has a target"):
        Recording({"time_s": TIME_S, "drive_voltage_v": STRAIN}, {}).plot("control")


def test_a_font_that_stands_in_for_the_journals_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("musclewire.figures._style.installed", lambda fonts: [fonts[-1]])
    assert "Arial" in figure_style("ieee-single").substitute
    assert "DejaVu Sans" in figure_style("ieee-single").substitute
    assert figure_style("screen").substitute == ""
    monkeypatch.setattr("musclewire.figures._style.installed", list)
    assert figure_style("ieee-single").substitute == ""


def test_python_warns_at_the_callers_line_of_a_font_that_stands_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("musclewire.figures._style.installed", lambda fonts: [fonts[-1]])
    with pytest.warns(SubstituteFontWarning, match="Arial") as said:
        RUN.plot("time", style="nature")
    assert said[0].filename == __file__


def test_a_style_without_a_substitute_is_silent() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        RUN.plot("time", style="screen")
