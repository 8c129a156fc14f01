from __future__ import annotations

import pickle

import pytest

from musclewire import errors
from musclewire.errors import (
    CallerError,
    FitRejectedError,
    MissingExtraError,
    MusclewireError,
    NumericsError,
    RecordingError,
    RigError,
    nearest_hint,
)


@pytest.mark.parametrize(
    ("error", "exit_code"),
    [(CallerError, 2), (RecordingError, 2), (RigError, 3), (NumericsError, 1), (FitRejectedError, 1)],
)
def test_the_owner_of_an_error_decides_the_exit_code(error: type[MusclewireError], exit_code: int) -> None:
    assert error("anything").exit_code == exit_code


def test_everything_raised_on_purpose_can_be_caught_in_one_place() -> None:
    kinds = [getattr(errors, name) for name in errors.__all__ if name.endswith("Error")]
    assert len(kinds) == 8
    assert all(issubclass(kind, MusclewireError) for kind in kinds)


@pytest.mark.parametrize("kind", [CallerError, RecordingError])
def test_wrong_input_is_also_a_value_error(kind: type[Exception]) -> None:
    assert issubclass(kind, ValueError)


def test_a_missing_extra_says_what_to_install() -> None:
    message = str(MissingExtraError("reading Parquet", "parquet"))
    assert message == "reading Parquet needs the extra 'parquet': pip install \".[parquet]\" in the checkout"


def test_a_name_nearly_right_is_answered_with_the_right_one() -> None:
    assert nearest_hint("pretention_n", ["pretension_n", "legs"]) == "; did you mean 'pretension_n'?"


def test_a_name_like_nothing_known_is_answered_with_all_names_in_order() -> None:
    assert nearest_hint("zzz", ["wire", "bench"]) == "; known: bench, wire"


def test_there_is_no_hint_where_nothing_is_known() -> None:
    assert nearest_hint("zzz", []) == ""


def test_an_error_of_a_process_in_a_pool_is_raised_as_it_was() -> None:
    error = MissingExtraError("reading Parquet", "parquet")
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again)) == (MissingExtraError, str(error))
