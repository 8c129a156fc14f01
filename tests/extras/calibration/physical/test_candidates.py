"""A vector stands for a wire: there and back, within the bounds, and nothing else changed."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from made_wires import candidates

from musclewire.extras.calibration import CandidateParameters
from musclewire.extras.calibration._physical.candidates import candidate_constants
from musclewire.parameters import GrainQuantiles, load_alloy, load_bench, load_priors, load_wire
from musclewire.wire import constants_from


@given(st.integers(0, 2**32 - 1))
def test_a_draw_lies_within_the_bounds_and_comes_back(seed: int) -> None:
    space = candidates()
    drawn = space.draw(np.random.default_rng(seed))
    numbers = space.numbers(drawn)
    assert np.all((space.low < drawn) & (drawn < space.high))
    assert np.allclose(space.coordinates(numbers), drawn)
    assert all(prior.low < one < prior.high for prior, one in zip(space.priors, numbers, strict=True))


def test_zero_is_the_priors_mean_and_one_its_deviation() -> None:
    space = candidates()
    assert np.allclose(space.numbers(np.zeros(len(space))), [prior.mean for prior in space.priors])
    assert np.allclose(
        space.numbers(np.ones(len(space))) - space.numbers(np.zeros(len(space))), [prior.std for prior in space.priors]
    )


def test_each_number_goes_to_its_group_and_the_rest_stays() -> None:
    wire, bench = load_wire("paper-100um"), load_bench("paper")
    alloy = load_alloy(wire.alloy)
    space = CandidateParameters(load_priors(), alloy, wire, bench, only=["latent_heat_j_per_kg", "guide_friction_n"])
    assert space.names == ("latent_heat_j_per_kg", "guide_friction_n")
    values = space.wire_values(np.array([1.0, -1.0]))
    priors = load_priors().parameters
    assert (
        values.alloy["latent_heat_j_per_kg"] == priors["latent_heat_j_per_kg"].mean + priors["latent_heat_j_per_kg"].std
    )
    assert values.bench["guide_friction_n"] == priors["guide_friction_n"].mean - priors["guide_friction_n"].std
    assert values.wire == wire.values()
    assert {**values.alloy, "latent_heat_j_per_kg": 0.0} == {**alloy.values(), "latent_heat_j_per_kg": 0.0}


def test_measured_grains_are_kept_and_what_they_replace_is_left_alone() -> None:
    grains = GrainQuantiles(fraction=(0.0, 0.5, 1.0), offset=(-4.7, 0.0, 4.0), kind="measured", source="an isobar")
    wire, bench = load_wire("paper-100um"), load_bench("paper")
    alloy = load_alloy(wire.alloy).model_copy(update={"grain_quantiles": grains})
    space = CandidateParameters(load_priors(), alloy, wire, bench)
    assert not {"grain_skew", "grain_tail", "early_fraction", "early_width"} & set(space.names)
    values = space.wire_values(np.zeros(len(space)))
    found = candidate_constants(values, values.wire, values.bench)
    assert np.array_equal(found.distribution_cells, constants_from(alloy, wire, bench).distribution_cells)
