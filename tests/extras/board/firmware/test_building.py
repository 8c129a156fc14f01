"""What firmware/build.py refuses, in one line that says what to do; nothing is compiled for these."""

from __future__ import annotations

from pathlib import Path

import pytest
from emulation.board import EmulatedBoard
from firmware.build import MODEL, WIRE, board_description, boards, write_sources

from musclewire.errors import CallerError


def changed_wire(tmp_path: Path, old: str, new: str) -> Path:
    text = WIRE.read_text(encoding="utf-8")
    assert old in text
    changed = tmp_path / "wire.toml"
    changed.write_text(text.replace(old, new), encoding="utf-8")
    return changed


def test_an_unknown_board_is_refused_with_the_nearest() -> None:
    with pytest.raises(CallerError, match="did you mean 'arduino-uno'"):
        board_description("arduino")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('wire = "paper-100um"', 'wire = "flexinol-0.10-lt"', "flexinol-0.10-lt: give the file of your wire by --wire"),
        ('"140 mm"', '"120 mm"', "120 mm: give the file of your wire by --wire"),
        ('shunt = "1 ohm"', 'shunt = "2 ohm"', "shunt of 1 ohm and the wire file says 2 ohm"),
        ('"3.6 V"', '"6 V"', "gives 5 V at most"),
        ("pretension", "pretention", "pretension"),
    ],
)
def test_a_wire_that_is_not_the_boards_or_the_models_is_refused_and_nothing_written(
    old: str, new: str, said: str, tmp_path: Path
) -> None:
    wire = changed_wire(tmp_path, old, new)
    with pytest.raises(CallerError, match=said):
        write_sources("arduino-uno", MODEL, wire, tmp_path / "built")
    assert not (tmp_path / "built").exists()


def test_files_that_are_not_there_are_named(tmp_path: Path) -> None:
    with pytest.raises(CallerError, match=r"no wire file .*nowhere\.toml"):
        write_sources("mps2-an386", MODEL, tmp_path / "nowhere.toml", tmp_path)
    with pytest.raises(CallerError, match=r"nowhere\.json"):
        write_sources("mps2-an386", tmp_path / "nowhere.json", WIRE, tmp_path)


@pytest.mark.parametrize("board", boards())
def test_the_numbers_of_every_board_reach_its_firmware(board: str, tmp_path: Path) -> None:
    write_sources(board, MODEL, WIRE, tmp_path)
    lines = (tmp_path / "src" / "board_constants.h").read_text(encoding="utf-8").splitlines()
    told = dict(line.split(" ", 2)[1:] for line in lines if line.startswith("#define MW_") and line.count(" ") >= 2)
    known = board_description(board)
    assert float(told["MW_TICK_S"].rstrip("f")) == known["tick_period_s"]
    assert int(told["MW_CONTROL_TICKS"].rstrip("u")) * known["tick_period_s"] == pytest.approx(
        known["control_period_s"]
    )
    assert float(told["MW_NODE_RANGE_V"].rstrip("f")) * known["divider_share"] == known["converter_range_v"]
    assert float(told["MW_SHUNT_RANGE_V"].rstrip("f")) * known["shunt_gain"] == known["converter_range_v"]


def test_the_arduino_has_no_lockstep() -> None:
    with pytest.raises(CallerError, match="by the clock only"):
        EmulatedBoard(board="arduino-uno", pace="lockstep")
