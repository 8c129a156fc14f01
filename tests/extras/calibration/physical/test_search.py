"""The search on problems whose answer is known, its journal, and what stops it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from musclewire.errors import CallerError, NumericsError
from musclewire.extras.calibration import SearchSettings
from musclewire.extras.calibration._physical.search import (
    EFFORTS,
    ParallelProblem,
    SearchJournal,
    SearchResult,
    jacobian,
    search,
    settings_of_effort,
    threads,
)

Array = NDArray[np.float64]


class Linear:
    """Residuals A x - b over noise 1, then the prior's: the answer is ridge regression."""

    low, high = np.full(4, -5.0), np.full(4, 5.0)
    matrix = np.random.default_rng(1).normal(size=(30, 4))
    measured = matrix @ np.array([1.0, -2.0, 0.5, 3.0]) + 0.3 * np.random.default_rng(2).normal(size=30)

    def residuals(self, coordinates: Array) -> Array:
        return np.concatenate([self.matrix @ coordinates - self.measured, coordinates])

    def start(self, number: int, drawn: Array) -> Array:  # noqa: ARG002
        return drawn

    def refined(self) -> Linear:
        return self

    def answer(self) -> Array:
        normal = self.matrix.T @ self.matrix + np.eye(4)
        return np.asarray(np.linalg.solve(normal, self.matrix.T @ self.measured))


class Wavy(Linear):
    """A valley with ripples: a descent with sharp data stops in one of them, a graduated one does not."""

    def residuals(self, coordinates: Array) -> Array:
        observed = 30.0 * (coordinates - 2.0) + 4.0 * np.sin(9.0 * coordinates)
        return np.concatenate([observed, coordinates])


class Impossible(Linear):
    def residuals(self, coordinates: Array) -> Array:  # noqa: ARG002
        raise NumericsError("ran away")


def test_a_linear_problem_is_solved_as_ridge_regression_solves_it() -> None:
    found = search(Linear(), SearchSettings(seed=3))
    assert found.coordinates == pytest.approx(Linear().answer(), abs=1e-6)
    assert found.jacobian[:30] == pytest.approx(Linear.matrix, abs=1e-6)
    assert found.cost == pytest.approx(float(found.residuals @ found.residuals))
    assert min(found.costs) == pytest.approx(found.cost, rel=1e-6)


def test_the_best_of_a_rippled_valley_is_found() -> None:
    grid = np.linspace(-5.0, 5.0, 200_001)
    least = 4.0 * float(np.min((30.0 * (grid - 2.0) + 4.0 * np.sin(9.0 * grid)) ** 2 + grid**2))
    assert search(Wavy(), SearchSettings(seed=1)).cost == pytest.approx(least, rel=1e-3)


def test_bounds_are_kept() -> None:
    problem = Linear()
    problem.high = np.array([5.0, 5.0, 5.0, 1.0])
    found = search(problem, SearchSettings())
    assert found.coordinates[3] == pytest.approx(1.0, abs=1e-3)
    assert np.all(found.coordinates <= problem.high)


def same(one: SearchResult, other: SearchResult) -> bool:
    return (
        one.coordinates.tobytes() == other.coordinates.tobytes()
        and one.jacobian.tobytes() == other.jacobian.tobytes()
        and one.costs == other.costs
        and one.simulations == other.simulations
    )


def test_one_seed_gives_one_answer_to_the_bit_whatever_the_threads() -> None:
    first, second = (search(Wavy(), SearchSettings(seed=7, threads=count)) for count in (1, 4))
    assert same(first, second)


class StopNowError(Exception):
    pass


@pytest.mark.parametrize("steps", [1, 40, 150])
def test_a_stopped_search_goes_on_to_the_same_answer_to_the_bit(steps: int, tmp_path: Path) -> None:
    whole = search(Wavy(), SearchSettings(seed=5))
    left = steps

    def stop_later() -> None:
        nonlocal left
        left -= 1
        if left < 0:
            raise StopNowError

    path = tmp_path / "wire.toml.search"
    with pytest.raises(StopNowError):
        search(Wavy(), SearchSettings(seed=5), journal=SearchJournal(path, "one"), on_step=stop_later)
    assert same(search(Wavy(), SearchSettings(seed=5), journal=SearchJournal(path, "one")), whole)


def test_progress_counts_descents_and_names_the_stage() -> None:
    seen: list[tuple[str, int, int]] = []
    search(
        Linear(),
        SearchSettings(starts=2, jumps=1),
        on_progress=lambda stage, done, total, _: seen.append((stage, done, total)),
    )
    assert seen == [("global search", 1, 3), ("global search", 2, 3), ("global search", 3, 3), ("local search", 1, 1)]


def test_where_no_vector_can_be_simulated_the_search_says_so() -> None:
    with pytest.raises(NumericsError, match="no candidate could be simulated"):
        search(Impossible(), SearchSettings(starts=1, jumps=0))


def test_a_derivative_beside_a_bound_looks_inward() -> None:
    problem = Linear()
    with threads(1) as each:
        parallel = ParallelProblem(problem, each)
        here = parallel.residuals(problem.high)
        assert here is not None
        slope = jacobian(parallel, problem.high, here, 0.1, central=False)
    assert slope[:30] == pytest.approx(Linear.matrix)


def test_efforts_are_known_by_their_words() -> None:
    assert settings_of_effort("normal") == SearchSettings()
    assert EFFORTS["quick"].starts < EFFORTS["thorough"].starts
    with pytest.raises(CallerError, match="did you mean 'quick'"):
        settings_of_effort("quik")


@pytest.mark.parametrize("wrong", [{"starts": 0}, {"jumps": -1}, {"threads": 0}, {"evaluations_each": 0}])
def test_a_search_that_would_not_search_is_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(CallerError, match="a search needs"):
        SearchSettings(**wrong)


def test_only_ends_that_are_about_as_good_as_the_best_say_how_far_apart_descents_end() -> None:
    ends = np.array([[0.0], [3.0], [0.1], [9.0]])
    found = SearchResult(ends[0], np.zeros(1), np.zeros((1, 1)), (100.0, 800.0, 104.0, np.inf), ends, 1)
    assert found.best_ends.ravel().tolist() == [0.0, 0.1]


@pytest.mark.parametrize("seed", [-1, 1.5, "one"])
def test_an_impossible_seed_is_refused(seed: int) -> None:
    with pytest.raises(CallerError, match="seed"):
        SearchSettings(seed=seed)
