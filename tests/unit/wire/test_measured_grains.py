"""Measured quantiles of the grains go wherever an alloy goes: wires, studies, files."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wire_makers import alloy, bench, wire_100um

from musclewire.parameters import Alloy, GrainQuantiles
from musclewire.wire import constants_from, constants_of, isobaric_path, tabulated_distribution, two_populations
from musclewire.wire._distribution import two_population_distribution

FRACTION = (0.0, 0.17, 0.5, 0.9, 1.0)
OFFSET = (-4.7, -1.0, 0.0, 1.4, 4.0)


def measured(fraction: tuple[float, ...] = FRACTION, offset: tuple[float, ...] = OFFSET) -> Alloy:
    table = GrainQuantiles(fraction=fraction, offset=offset, kind="measured", source="an isobar")
    return alloy().model_copy(update={"grain_quantiles": table})


def test_a_wire_has_the_distribution_through_its_quantiles() -> None:
    table = tabulated_distribution(np.array(OFFSET), np.array(FRACTION))
    given_in_python = constants_of(alloy().values(), wire_100um().values(), bench().values(), distribution=table)
    found = constants_from(measured(), wire_100um(), bench())
    assert np.array_equal(found.distribution_cells, given_in_python.distribution_cells)
    assert np.array_equal(found.numbers, given_in_python.numbers)


def test_two_wires_of_one_table_share_it_and_a_pickled_one_is_the_same() -> None:
    """A batch joins wires by their table's place in memory; a study sends wires to other processes."""
    one, two = (constants_from(measured(), wire_100um(), bench()) for _ in range(2))
    assert one.distribution_cells.ctypes.data == two.distribution_cells.ctypes.data
    again = pickle.loads(pickle.dumps(one))
    assert np.array_equal(again.distribution_cells, one.distribution_cells)


@settings(max_examples=15, deadline=None)
@given(early=st.floats(0.05, 0.4), width=st.floats(1.0, 6.0))
def test_quantiles_of_two_populations_make_their_isobar(early: float, width: float) -> None:
    """A fine table of the family's own quantiles is the family: martensite agrees to 0.2 %."""
    z = np.linspace(-4.5, 4.5, 2001)
    cumulative = two_population_distribution(-0.2, 0.5, early, width).cumulative
    offset = two_populations(z, -0.2, 0.5, early, width)
    offset = np.unique(np.concatenate((offset, [offset[0] - 1e-3, offset[-1] + 1e-3])))
    fraction = cumulative(offset)
    fraction[0], fraction[-1] = 0.0, 1.0
    rising = np.flatnonzero(np.diff(fraction, prepend=-1.0) > 0.0)
    table = measured(tuple(fraction[rising].tolist()), tuple(offset[rising].tolist()))
    family = alloy(grain_skew=-0.2, grain_tail=0.5, early_fraction=early, early_width=width)
    kelvin = np.concatenate((np.linspace(280.0, 430.0, 300), np.linspace(430.0, 280.0, 300)))
    tabulated, formula = (
        isobaric_path(constants_from(each, wire_100um(), bench()), 120e6, kelvin).martensite_fraction
        for each in (table, family)
    )
    assert tabulated == pytest.approx(formula, abs=2e-3)
