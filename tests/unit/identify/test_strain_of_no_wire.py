"""A strain that no wire has is refused by fit and estimate, from whichever column it follows, with its rows."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.errors import RecordingError
from musclewire.identify import estimate, fit
from musclewire.signals import Recording


@pytest.mark.parametrize(("column", "cause"), [("displacement_m", "the length of the wire"), ("reference_strain", "")])
def test_a_strain_of_no_wire_is_refused_with_its_rows(loop: Recording, column: str, cause: str) -> None:
    moved = loop["displacement_m"] / (1.0 if column == "displacement_m" else loop.facts.leg_length_m)
    # A sensor that lost its target for a while and drifted on.
    lost = (loop["time_s"] >= 20.0) & (loop["time_s"] < 30.0)
    columns = {name: values for name, values in loop.columns.items() if name != "displacement_m"}
    wrong = Recording(
        {**columns, column: np.where(lost, moved + (moved.max() + loop["time_s"] - 15.0) / 25.0, moved)}, loop.metadata
    )
    said = rf"{lost.sum()} of 3600 rows, the first at 20 s, are at a strain of up to .* correct {column}.*{cause}"
    with pytest.raises(RecordingError, match=said):
        fit(wrong)
    with pytest.raises(RecordingError, match=said):
        estimate(fit(loop), wrong)


def test_a_stroke_of_a_coil_is_fitted_as_a_displacement(loop: Recording) -> None:
    coil = loop.with_columns(displacement_m=10.0 * loop["displacement_m"])
    assert estimate(fit(coil, quantity="displacement"), coil).rms_pct < 2.0
