"""The gated branches of the exported library are those of Python."""

from __future__ import annotations

from pathlib import Path

import pytest
from emulation.exported_library.on_this_machine import MAX_DIFFERENCE, HostLibrary, built, largest_differences
from tests.extras.board.export.export_parts import COOLING, HEATING, drive_limits, limits_for, usual_model
from tests.tools import require_tool

from musclewire.controllers import FuzzyPidSettings
from musclewire.errors import CallerError
from musclewire.extras.board._c import loop_checksum, write_library
from musclewire.extras.board._c.exercise import exercise, golden_ticks
from musclewire.sensing import SensingModel

LIMITS = limits_for(usual_model())
# Through B at 0.1 W, and cold again at 0.02 W.
SLOW_LOOP = (
    *((0.0, 0.01, 17.2), (10.0, 0.05, 17.3), (20.0, 0.1, 17.5), (30.0, 0.4, 15.2)),
    *((40.0, 0.05, 16.5), (50.0, 0.02, 17.2)),
)
MODELS = {
    "no slow loop": usual_model(),
    "slow loop": usual_model(slow_loop=SLOW_LOOP),
    "crossed branches": usual_model(heating_coefficients=COOLING, cooling_coefficients=HEATING, slow_loop=SLOW_LOOP),
}


@pytest.mark.parametrize("model", list(MODELS.values()), ids=list(MODELS))
@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
def test_gated_branches_in_c_are_those_of_python(tmp_path: Path, model: SensingModel, double: bool) -> None:
    require_tool("gcc", "gcc libc6-dev")
    numbers = (model, FuzzyPidSettings(), drive_limits(LIMITS), LIMITS)
    library = write_library(*numbers, tmp_path / "c", double=double, estimator="gated")
    loaded = HostLibrary(built(tmp_path / "c", tmp_path, double=double), double=double)
    slow = exercise(library.reference, 12, 500, tick_s=60.0, fault_probability=0.0)
    for ticks in (golden_ticks(library.reference), exercise(library.reference, 11, 2_000), slow):
        found = largest_differences(loaded, library.reference, ticks, relative=double)
        assert max(found.values()) <= MAX_DIFFERENCE[double], found


def test_the_estimator_is_part_of_the_checksum_and_only_two_have_a_c_form(tmp_path: Path) -> None:
    model, settings = usual_model(), FuzzyPidSettings()
    assert loop_checksum(model, settings) != loop_checksum(model, settings, estimator="gated")
    with pytest.raises(CallerError, match="no C form"):
        write_library(model, settings, drive_limits(LIMITS), LIMITS, tmp_path, estimator="gatted")
