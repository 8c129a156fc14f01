"""Priors: those that come along make sense, and a mistake in a file of one's own is one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from musclewire.errors import CallerError
from musclewire.parameters import load_priors
from musclewire.parameters._validation import shipped_names

MINE = """name = "mine"
description = "a wire"

[parameters.latent_heat_j_per_kg]
group = "alloy"
mean = 2e4
std = 3e3
low = 1e4
high = 3e4
unit = "J/kg"
source = "a calorimeter"
measure = "fast heating"
"""


@pytest.mark.parametrize("name", shipped_names("priors"))
def test_priors_that_come_along_lie_well_inside_their_bounds(name: str) -> None:
    found = load_priors(name)
    assert found.name == name
    for parameter, prior in found.parameters.items():
        assert prior.low <= prior.mean - 0.5 * prior.std, parameter
        assert prior.mean + 0.5 * prior.std <= prior.high, parameter


def test_priors_of_ones_own_are_read(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(MINE)
    assert load_priors(str(path)).parameters["latent_heat_j_per_kg"].mean == 2e4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("latent_heat_j_per_kg]", "latent_heat]", "'latent_heat' is no parameter of an alloy; did you mean"),
        ("mean = 2e4", "mean = 5e4", "must lie between low"),
        ('unit = "J/kg"', 'unit = "kJ/kg"', "it must be given in 'J/kg'"),
        ("std = 3e3", "std = 0.0", "std"),
    ],
)
def test_a_mistake_in_a_file_is_one_line(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = tmp_path / "mine.toml"
    assert old in MINE
    path.write_text(MINE.replace(old, new))
    with pytest.raises(CallerError) as caught:
        load_priors(str(path))
    assert words in str(caught.value)
