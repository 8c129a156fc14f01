"""Episodes: the paper's staircase, random levels, and the numbers that are refused."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.controllers import staircase
from musclewire.errors import CallerError
from musclewire.extras.interfaces._environments.episodes import Episode, episode_from


def test_by_default_it_is_the_papers_staircase() -> None:
    episode = Episode()
    assert episode.drawn(np.zeros(episode.levels)).tolist() == pytest.approx(list(staircase().levels))
    levels = episode.level_of_sample(0.05)
    assert levels.size == 1560 + 1
    assert np.bincount(levels).tolist() == [240 + 120, *[120] * 9, 120 + 1]


def test_random_levels_fill_the_range() -> None:
    episode = Episode("random", low=0.01, high=0.02)
    assert episode.drawn(np.array([0.0, 0.5, 1.0])).tolist() == pytest.approx([0.01, 0.015, 0.02])


def test_it_can_be_given_by_name_or_by_its_numbers() -> None:
    assert episode_from("random") == Episode("random") == episode_from({"targets": "random"})


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("stairs", "'staircase'"),
        ({"low": 0.03, "high": 0.02}, "the lower one first"),
    ],
)
def test_what_cannot_be_followed_is_refused_in_one_line(wrong: object, said: str) -> None:
    with pytest.raises(CallerError, match=said):
        episode_from(wrong)  # type: ignore[arg-type]
