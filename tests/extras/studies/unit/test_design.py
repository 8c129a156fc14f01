"""What a study varies, the design of its runs, and the sensitivities that follow."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.studies import ParameterTable
from musclewire.extras.studies._design import METHODS, StudyDesign, design_of, run_seed, saltelli_points, unit_cube
from musclewire.extras.studies._sensitivity import sensitivity_of
from musclewire.extras.studies._varied_parameters import GridAxis, SampledParameter, parameter_of, quantile_function

# Distributions of a parameter, against closed forms and printed tables.

# Of the standard normal distribution, as every table prints it.
NORMAL_975 = 1.959964


def quantile(probability: float, **given: Any) -> float:
    return float(quantile_function("parameters.x", "linear", given)(np.array([probability]))[0])


def test_a_normal_distribution_has_the_tables_quantile() -> None:
    assert quantile(0.975, distribution="normal", mean=10.0, std=2.0) == pytest.approx(10 + 2 * NORMAL_975, abs=1e-5)


def test_a_truncated_normal_distribution_stays_between_its_ends_and_keeps_its_middle() -> None:
    given = {"distribution": "normal", "mean": 10.0, "std": 2.0, "low": 9.0, "high": 11.0}
    assert quantile(0.5, **given) == pytest.approx(10.0)
    assert 9.0 < quantile(1e-9, **given) < quantile(1.0 - 1e-9, **given) < 11.0


def test_low_and_high_alone_are_uniform_and_with_a_log_spacing_log_uniform() -> None:
    assert quantile(0.25, low=1.0, high=5.0) == pytest.approx(2.0)
    found = quantile_function("parameters.x", "log", {"low": 1.0, "high": 100.0})(np.array([0.5]))
    assert found[0] == pytest.approx(10.0)


def test_two_thirds_of_a_log_normal_distribution_lie_within_its_factor() -> None:
    one_sigma = 0.5 * (1.0 + math.erf(1.0 / math.sqrt(2.0)))
    assert quantile(one_sigma, distribution="log-normal", median=3.0, factor=1.5) == pytest.approx(4.5)
    assert quantile(0.5, distribution="log-normal", median=3.0, factor=1.5) == pytest.approx(3.0)


def test_a_triangular_distribution_has_its_mode_where_its_area_says() -> None:
    # The area left of the mode is its distance from the lower end over the width.
    assert quantile(0.25, distribution="triangular", low=0.0, mode=1.0, high=4.0) == pytest.approx(1.0)


def test_any_continuous_distribution_of_scipy_is_known_by_its_name() -> None:
    # Weibull: 1 - exp(-(x / scale)^c).
    found = quantile(1.0 - math.exp(-1.0), distribution="weibull_min", shape={"c": 2.5}, scale=3.0, loc=1.0)
    assert found == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"distribution": "normel", "mean": 1.0}, "did you mean 'normal'"),
        ({"low": 2.0, "high": 1.0}, "'low' must be below 'high'"),
        ({"distribution": "log-normal", "median": -1.0, "factor": 2.0}, "numbers above 0"),
    ],
)
def test_numbers_that_make_no_distribution_are_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(CallerError, match=words.replace("(", r"\(").replace(".", r"\.")):
        quantile_function("parameters.x", "linear", given)


def test_units_are_taken_off_and_a_difference_of_temperatures_needs_one() -> None:
    table = ParameterTable(distribution="normal", mean="22 degC", std="2 K")
    found = parameter_of("ambient_temperature", "K", table)
    assert isinstance(found, SampledParameter)
    assert found.quantile(np.array([0.5]))[0] == pytest.approx(295.15)
    with pytest.raises(CallerError, match="difference of temperatures"):
        parameter_of("ambient_temperature", "K", ParameterTable(distribution="normal", mean="22 degC", std="2 degC"))


def test_points_are_an_axis_with_both_ends() -> None:
    linear = parameter_of("pretension", "N", ParameterTable(low="1 N", high="2 N", points=3))
    assert isinstance(linear, GridAxis)
    assert linear.values == pytest.approx((1.0, 1.5, 2.0))
    log = parameter_of("pretension", "N", ParameterTable(low=1.0, high=100.0, points=3, spacing="log"))
    assert isinstance(log, GridAxis)
    assert log.values == pytest.approx((1.0, 10.0, 100.0))


@pytest.mark.parametrize(
    ("unit", "table", "words"),
    [
        ("N", {"values": [1.0], "low": 1.0}, "'low' does not belong to 'values'"),
        ("N", {"values": ["1 mm"]}, "force is needed|needed, like"),
    ],
)
def test_keys_that_do_not_belong_together_are_refused(unit: str, table: dict[str, Any], words: str) -> None:
    with pytest.raises(CallerError, match=words):
        parameter_of("x", unit, ParameterTable(**table))


def test_a_prior_is_a_distribution_between_its_bounds() -> None:
    found = parameter_of("martensite_temperature_k", "K", ParameterTable(prior="niti-wire"))
    assert isinstance(found, SampledParameter)
    ends = found.quantile(np.array([1e-12, 1.0 - 1e-12]))
    from musclewire.parameters import load_priors

    prior = load_priors("niti-wire").parameters["martensite_temperature_k"]
    assert prior.low <= ends[0] < ends[1] <= prior.high


# The runs of a study: all points, all samples, the same each time.


def plain(values: FloatArray) -> FloatArray:
    return values


def sampled(name: str) -> SampledParameter:
    return SampledParameter(name, "1", plain)


axes = st.lists(st.integers(1, 4), max_size=3).map(
    lambda sizes: [GridAxis(f"a{place}", "N", tuple(10.0 * place + k for k in range(size)))
                   for place, size in enumerate(sizes)]
)  # fmt: skip


@given(axes, st.integers(0, 2), st.integers(1, 5))
def test_the_runs_are_every_point_of_the_grid_with_every_sample(grid: list[GridAxis], drawn: int, samples: int) -> None:
    design = design_of([*grid, *(sampled(f"s{k}") for k in range(drawn))], "random", samples, 3)
    points = list(itertools.product(*(axis.values for axis in grid)))
    rows = design.rows(0, len(design))
    assert len(rows) == len(points) * samples
    assert [row[: len(grid)] for row in rows] == [point for point in points for _ in range(samples)]
    for place, name in enumerate(design.names):
        assert design.column(name).tolist() == [row[place] for row in rows]


@given(axes, st.data())
def test_any_part_of_the_runs_is_that_part_of_all(grid: list[GridAxis], data: st.DataObject) -> None:
    design = design_of([*grid, sampled("s")], "latin-hypercube", 4, 1)
    first = data.draw(st.integers(0, len(design)))
    stop = data.draw(st.integers(first, len(design)))
    assert design.rows(first, stop) == design.rows(0, len(design))[first:stop]


@pytest.mark.parametrize("method", METHODS)
def test_the_same_seed_makes_the_same_runs_and_another_one_others(method: str) -> None:
    one, same, other = (unit_cube(method, 3, 16, seed) for seed in (5, 5, 6))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)
    assert ((one > 0.0) & (one < 1.0)).all()


def test_each_row_and_column_of_a_latin_hypercube_is_taken_once() -> None:
    cells = np.floor(unit_cube("latin-hypercube", 4, 50, 1) * 50).astype(int)
    assert all(sorted(column.tolist()) == list(range(50)) for column in cells.T)


def test_a_sobol_sequence_fills_every_dyadic_interval_equally() -> None:
    points = unit_cube("sobol", 3, 64, 2)
    for column in points.T:
        assert np.bincount((column * 64).astype(int), minlength=64).tolist() == [1] * 64


def test_saltellis_points_exchange_one_coordinate_at_a_time() -> None:
    pairs = np.arange(8.0).reshape(2, 4) / 10.0
    points = saltelli_points(pairs)
    assert points.tolist() == [
        [0.0, 0.1], [0.2, 0.1], [0.0, 0.3], [0.2, 0.3],
        [0.4, 0.5], [0.6, 0.5], [0.4, 0.7], [0.6, 0.7],
    ]  # fmt: skip


def test_the_seed_of_a_run_depends_on_its_number_alone() -> None:
    seeds = [run_seed(1, run) for run in range(1000)]
    assert len(set(seeds)) == 1000
    assert run_seed(1, 17) == seeds[17]
    assert run_seed(2, 17) != seeds[17]


def test_more_runs_than_anybody_evaluates_are_refused() -> None:
    with pytest.raises(CallerError, match="more than 10000000"):
        design_of([GridAxis(name, "N", tuple(map(float, range(300)))) for name in "abc"], "random", 1, 1)


# Indices of known functions: Ishigami's and a linear one have closed forms.

A, B = 7.0, 0.1


def wide(probability: FloatArray) -> FloatArray:
    return math.pi * (2.0 * probability - 1.0)


def ishigami(design: StudyDesign) -> FloatArray:
    x, y, z = design.samples.T[:3]
    return np.asarray(np.sin(x) + A * np.sin(y) ** 2 + B * z**4 * np.sin(x))


def closed_form() -> tuple[list[float], list[float]]:
    """First and total indices of Ishigami's function (Saltelli et al., Global Sensitivity Analysis, 2008, 4.9)."""
    first = 0.5 * (1.0 + B * math.pi**4 / 5.0) ** 2
    second = A**2 / 8.0
    together = B**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = first + second + together
    return [first / whole, second / whole, 0.0], [(first + together) / whole, second / whole, together / whole]


def three(method: str, samples: int) -> StudyDesign:
    return design_of([SampledParameter(name, "1", wide) for name in "xyz"], method, samples, 1)


def test_saltellis_design_gives_the_closed_forms_of_ishigamis_function() -> None:
    design = three("saltelli", 2048)
    rows = sensitivity_of(design, {"f": ishigami(design)}, 1)
    first, total = closed_form()
    assert [row.first for row in rows] == pytest.approx(first, abs=0.02)
    assert [row.total for row in rows] == pytest.approx(total, abs=0.02)
    assert [row.parameter for row in rows] == ["x", "y", "z"]


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube", "halton", "random"])
def test_any_other_sample_gives_the_first_indices(method: str) -> None:
    # The fourth has no effect. In four dimensions RBD-FAST takes a Sobol sequence's third for its first.
    design = design_of([SampledParameter(name, "1", wide) for name in "xyzw"], method, 4096, 1)
    rows = sensitivity_of(design, {"f": ishigami(design)}, 1)
    assert [row.first for row in rows] == pytest.approx([*closed_form()[0], 0.0], abs=0.04)
    # The third acts by its interaction with the first alone: its first index is 0, PAWN's is not.
    found = [row.pawn or 0.0 for row in rows]
    assert found[2] > 2.0 * found[3]


def test_the_indices_of_a_grid_are_exact() -> None:
    x, y = np.linspace(-1.0, 1.0, 5), np.linspace(-1.0, 1.0, 9)
    design = design_of([GridAxis("x", "1", tuple(x.tolist())), GridAxis("y", "1", tuple(y.tolist()))], "random", 1, 1)
    values = (3.0 * x[:, None] + 2.0 * y[None, :] + x[:, None] * y[None, :]).ravel()
    rows = sensitivity_of(design, {"f": values}, 1)
    parts = [9.0 * x.var(), 4.0 * y.var(), x.var() * y.var()]
    assert [row.first for row in rows] == pytest.approx([parts[0] / sum(parts), parts[1] / sum(parts)])


@pytest.mark.parametrize("method", ["saltelli", "sobol"])
def test_over_a_grid_all_indices_are_of_one_variance(method: str) -> None:
    """Of 3 g + 2 x + g x with g of -1, 0, 1 and x uniform from -1 to 1; y does nothing."""
    sampled = [SampledParameter(name, "1", lambda probability: 2.0 * probability - 1.0) for name in "xy"]
    design = design_of([GridAxis("g", "1", (-1.0, 0.0, 1.0)), *sampled], method, 1024, 1)
    g, x = np.array([-1.0, 0.0, 1.0])[:, None], design.samples[:, 0]
    rows = sensitivity_of(design, {"f": (3.0 * g + 2.0 * x + g * x).ravel()}, 1)
    of_g, of_x, together = 6.0, 4.0 / 3.0, 2.0 / 9.0
    whole = of_g + of_x + together
    assert [row.parameter for row in rows] == ["g", "x", "y"]
    assert [row.first for row in rows] == pytest.approx([of_g / whole, of_x / whole, 0.0], abs=0.02)
    if method == "saltelli":
        assert [row.total for row in rows] == [
            None,
            pytest.approx((of_x + together) / whole, abs=0.02),
            pytest.approx(0.0, abs=0.02),
        ]
    assert 0.0 < float(rows[0].first_error or 0.0) < 0.05


def test_failed_runs_are_left_out_of_a_sample_and_end_a_complete_design() -> None:
    design = three("sobol", 4096)
    values = ishigami(design)
    values[::17] = np.nan
    assert [row.first for row in sensitivity_of(design, {"f": values}, 1)] == pytest.approx(closed_form()[0], abs=0.04)
    complete = three("saltelli", 64)
    values = ishigami(complete)
    values[3] = np.nan
    assert sensitivity_of(complete, {"f": values}, 1) == []


def test_a_constant_quantity_and_a_series_have_no_indices() -> None:
    design = three("sobol", 64)
    assert sensitivity_of(design, {"f": np.ones(64), "g": np.ones((64, 3))}, 1) == []
