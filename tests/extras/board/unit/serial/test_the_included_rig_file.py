"""The rig file of a board that comes with musclewire, and what is refused of one."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.places import included_rig_file

from musclewire.errors import CallerError
from musclewire.rigs import open_rig, read_rig_file


def test_air_in_degrees_without_a_unit_is_refused_because_it_would_let_the_wire_grow_too_hot(tmp_path: Path) -> None:
    board, path = included_rig_file("serial-board").read_text("utf-8"), tmp_path / "my_rig.toml"
    path.write_text("ambient_temperature = 22\n" + board, "utf-8")
    with pytest.raises(CallerError, match=r"ambient_temperature: must be 223.15 K or more, not 22"):
        read_rig_file(path)
    path.write_text('ambient_temperature = "22 degC"\n' + board, "utf-8")
    assert read_rig_file(path).ambient_temperature == 295.15  # type: ignore[union-attr]


def test_the_clock_of_a_board_cannot_be_made_faster() -> None:
    with pytest.raises(CallerError, match="is not simulated, its clock runs as it does"):
        open_rig("serial-board", clock_speed=10.0)
