"""The gated branches of the exported library are those of Python."""

from __future__ import annotations

from pathlib import Path

import pytest
from emulation.exported_library.on_this_machine import MAX_DIFFERENCE, HostLibrary, built, largest_differences
from tests.extras.board.export.export_parts import COOLING, HEATING, SLOW_LOOP, drive_limits, limits_for, usual_model
from tests.tools import require_tool

from musclewire.controllers import FuzzyPidSettings
from musclewire.errors import CallerError
from musclewire.extras.board._c import loop_checksum, write_library
from musclewire.extras.board._c.exercise import exercise, golden_ticks
from musclewire.sensing import SensingModel

LIMITS = limits_for(usual_model())
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


def test_the_estimator_is_part_of_the_checksum_and_others_have_no_c_form(tmp_path: Path) -> None:
    model, settings = usual_model(), FuzzyPidSettings()
    assert loop_checksum(model, settings) != loop_checksum(model, settings, estimator="gated")
    with pytest.raises(CallerError, match="no C form"):
        write_library(model, settings, drive_limits(LIMITS), LIMITS, tmp_path, estimator="gatted")
