from __future__ import annotations

import json
import math
import warnings
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.sensing import SensingModel

mpl.use("Agg")

MODEL = SensingModel(
    resistance_min_ohm=15.0,
    resistance_max_ohm=17.0,
    heating_coefficients=(0.0352, -0.03),
    cooling_coefficients=(0.0348, -0.03),
    normalised_min=0.0,
    normalised_max=1.0,
    hysteresis_gap=0.0114,
    samples=400,
    wire={"name": "d100", "diameter_m": 1e-4},
)


@st.composite
def monotone_models(draw: st.DrawFn) -> SensingModel:
    """Any g_a with a falling slope -(floor + p(lambda)^2), and branches that differ."""
    root = np.polynomial.Polynomial(draw(st.lists(st.floats(-0.2, 0.2), min_size=1, max_size=4)))
    slope = -(root**2 + draw(st.floats(1e-4, 0.02)))
    mean = slope.integ(k=[0.035]).coef
    apart = np.resize(draw(st.lists(st.floats(-1e-3, 1e-3), min_size=1, max_size=3)), mean.size)
    low = draw(st.floats(10, 20))
    begin = draw(st.floats(0.0, 0.4))
    return SensingModel(
        resistance_min_ohm=low,
        resistance_max_ohm=low + draw(st.floats(0.5, 5)),
        heating_coefficients=tuple((mean + apart).tolist()),
        cooling_coefficients=tuple((mean - apart).tolist()),
        normalised_min=begin,
        normalised_max=begin + draw(st.floats(0.2, 0.6)),
        rmse_heating=draw(st.floats(0, 1e-3)),
        resistance_noise_ohm=draw(st.floats(0, 0.01)),
        scale_std=draw(st.floats(0, 0.1)),
        offset_std=draw(st.floats(0, 1e-3)),
    )


@settings(deadline=None)
@given(monotone_models(), st.lists(st.floats(0, 1), min_size=1, max_size=20))
def test_the_inverse_of_the_average_returns_the_resistance(model: SensingModel, places: list[float]) -> None:
    low, high = model.valid_resistance_ohm
    resistance = low + np.array(places) * (high - low)
    assert model.resistance_ohm(model.strain(resistance)) == pytest.approx(resistance, abs=1e-8 * high)
    one = model.resistance_ohm(model.strain(float(resistance[0])))
    assert isinstance(one, float)
    assert one == pytest.approx(resistance[0], abs=1e-8 * high)


@settings(deadline=None)
@given(monotone_models(), st.floats(0, 1))
def test_the_average_of_the_inverse_returns_the_strain(model: SensingModel, place: float) -> None:
    strain = model.quantity_min + place * (model.quantity_max - model.quantity_min)
    assert model.strain(model.resistance_ohm(strain)) == pytest.approx(strain, abs=1e-12)


@settings(deadline=None)
@given(monotone_models(), st.floats(allow_nan=True, allow_infinity=True))
def test_any_resistance_gives_a_finite_estimate_within_the_range(model: SensingModel, resistance: float) -> None:
    estimate = model.estimate(resistance)
    assert model.quantity_min - 1e-12 <= estimate.value <= model.quantity_max + 1e-12
    assert 0.0 <= estimate.std <= model.quantity_max - model.quantity_min
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of another wire's resistance
        assert math.isfinite(model.strain(resistance))


def test_no_reading_reads_as_fully_contracted_and_invalid() -> None:
    for resistance in (0.0, math.nan, math.inf, -math.inf):
        estimate = MODEL.estimate(resistance)
        assert estimate.value == pytest.approx(MODEL.quantity_max)
        assert not estimate.valid
    many = MODEL.estimate(np.array([[0.0, math.nan], [math.inf, 16.0]]))
    assert many.valid.tolist() == [[False, False], [False, True]]
    assert many.value[0] == pytest.approx([MODEL.quantity_max] * 2)


def test_a_resistance_just_outside_still_counts_and_a_far_one_does_not() -> None:
    assert MODEL.estimate(14.97).valid
    assert not MODEL.estimate(14.9).valid
    assert MODEL.estimate(17.03).valid
    assert not MODEL.estimate(17.1).valid
    assert MODEL.strain(14.9) == MODEL.strain(15.0)


@pytest.mark.parametrize("read", ["value", "strain", "strain_heating", "strain_cooling"])
def test_a_resistance_of_another_wire_reads_as_the_end_and_says_so(read: str) -> None:
    of = getattr(MODEL, read)
    with pytest.warns(UserWarning, match=r"^40 ohm, outside the 15 to 17 ohm .* wire\?") as caught:
        assert of(40.0) == of(17.0)
    assert caught[0].filename == __file__
    with pytest.warns(UserWarning, match=r"^2 of 3 readings, the first 40 ohm"):
        assert of(np.array([16.0, 40.0, 10.0])).tolist() == [of(16.0), of(17.0), of(15.0)]


def test_readings_of_the_cold_part_and_missing_ones_are_no_reason_to_warn() -> None:
    MODEL.strain(np.array([14.8, 17.2, math.nan, math.inf]))
    MODEL.strain(math.nan)
    MODEL.strain(np.array([]))


def test_the_spread_holds_half_the_gap_the_residual_the_noise_and_what_no_instrument_has_measured() -> None:
    """Where the strain is 2 %, 5 % of it are 1e-3."""
    rough = replace(MODEL, rmse_heating=3e-4, rmse_cooling=3e-4)
    assert MODEL.estimate(16.0).std == pytest.approx(2e-4)
    assert rough.estimate(16.0).std == pytest.approx(math.hypot(2e-4, 3e-4))
    assert rough.estimate(16.0, 0.01).std == pytest.approx(math.hypot(2e-4, 3e-4, 0.01 * 0.015))
    found = replace(MODEL, scale_std=0.05, offset_std=3e-4).estimate(np.array([16.0]))
    assert found.value[0] == MODEL.estimate(16.0).value
    assert found.std[0] == pytest.approx(math.hypot(2e-4, 3e-4, 0.05 * found.value[0]))


def test_a_strain_out_of_reach_is_refused_with_the_range() -> None:
    for strain in (0.04, 0.0, math.nan):
        with pytest.raises(CallerError, match=r"outside the model's valid range 0\.5 to 3\.5 %"):
            MODEL.resistance_ohm(strain)
    with pytest.raises(CallerError, match="strain 4 %"):
        MODEL.resistance_ohm(np.array([0.02, 0.04]))
    assert MODEL.resistance_ohm(0.0351) == pytest.approx(15.0)


def test_branches_lie_on_their_sides_of_the_average() -> None:
    assert MODEL.strain_heating(16.0) == pytest.approx(0.0202)
    assert MODEL.strain_cooling(16.0) == pytest.approx(0.0198)
    assert MODEL.strain(np.array([16.0])) == pytest.approx([0.02])


def test_a_model_of_displacement_does_not_pass_for_one_of_strain() -> None:
    model = replace(MODEL, quantity="displacement")
    assert model.unit == "m"
    assert model.value(16.0) == pytest.approx(0.02)
    with pytest.raises(CallerError, match="not of strain"):
        model.strain(16.0)
    with pytest.raises(CallerError, match="valid range 5 to 35 mm"):
        model.resistance_ohm(0.05)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"resistance_max_ohm": 14.0}, "minimum below the maximum"),
        ({"heating_coefficients": (0.03, -0.02, 0.0)}, "fit both alike"),
        ({"heating_coefficients": (0.03, 0.05)}, "cannot be inverted"),
        ({"normalised_min": 0.9, "normalised_max": 0.5}, "must rise"),
        ({"quantity": "strian"}, "did you mean 'strain'"),
        ({"rmse_average": math.inf}, "must be from 0 to"),
    ],
)
def test_parts_that_contradict_each_other_make_no_model(change: dict[str, object], message: str) -> None:
    with pytest.raises(CallerError, match=message):
        replace(MODEL, **change)  # type: ignore[arg-type]


def test_the_notebook_table_escapes_what_came_from_a_file() -> None:
    html = replace(MODEL, source="<script>", wire={"<b>": "<i>"})._repr_html_()
    assert "<script>" not in html
    assert "<i>" not in html
    assert "&lt;script&gt;" in html


def test_the_report_has_the_keys_of_the_command_line() -> None:
    report = MODEL.report()
    keys = "strain_gap_pct resistance_min_ohm resistance_max_ohm order rmse_heating_pct rmse_cooling_pct"
    assert {*keys.split(), "rmse_average_pct", "samples", "warnings"} <= set(report)
    assert json.loads(json.dumps(report)) == report
    assert report["strain_gap_pct"] == pytest.approx(1.14)


def test_a_plot_is_drawn_on_the_axes_given_or_on_its_own() -> None:
    from matplotlib import pyplot
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    kept = replace(MODEL, heating_samples=((16.0, 0.02),), cooling_samples=((16.0, 0.02),))
    assert kept.plot(axes) is axes
    assert max(line.get_ydata().max() for line in axes.lines) == pytest.approx(3.52)  # type: ignore[union-attr]
    figure = MODEL.plot(style="nature").figure
    assert figure.get_size_inches()[0] * 25.4 == pytest.approx(89.0)
    assert pyplot.gcf() is figure  # so that a notebook shows it
    pyplot.close(figure)
