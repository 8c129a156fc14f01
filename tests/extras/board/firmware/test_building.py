"""What firmware/build.py refuses, in one line that says what to do; nothing is compiled for these."""

from __future__ import annotations

from pathlib import Path

import pytest
from emulation.board import EmulatedBoard
from firmware.build import MODELS, board_description, boards, mounted_wire, simulated_model, write_sources

from musclewire.errors import CallerError
from musclewire.rigs import own_circuit
from musclewire.sensing import load_model


def changed_wire(tmp_path: Path, old: str, new: str) -> Path:
    text = (MODELS / "paper-100um.toml").read_text(encoding="utf-8")
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
        ('wire = "paper-100um"', 'wire = "flexinol-0.10-lt"', "flexinol-0.10-lt: give your wire by --wire"),
        ('"140 mm"', '"120 mm"', "120 mm: give your wire by --wire"),
        ('"3.6 V"', '"6 V"', "gives 5 V at most"),
        ("pretension", "pretention", "pretension"),
    ],
)
def test_a_wire_that_is_not_the_boards_or_the_models_is_refused_and_nothing_written(
    old: str, new: str, said: str, tmp_path: Path
) -> None:
    wire = changed_wire(tmp_path, old, new)
    with pytest.raises(CallerError, match=said):
        write_sources("arduino-uno", tmp_path / "built", wire=wire, model_file=MODELS / "paper-100um.json")
    assert not (tmp_path / "built").exists()


@pytest.mark.parametrize("board", boards())
def test_the_numbers_of_every_board_reach_its_firmware(board: str, tmp_path: Path) -> None:
    write_sources(board, tmp_path)
    lines = (tmp_path / "src" / "board_constants.h").read_text(encoding="utf-8").splitlines()
    told = dict(line.split(" ", 2)[1:] for line in lines if line.startswith("#define MW_") and line.count(" ") >= 2)
    known = board_description(board)
    assert float(told["MW_TICK_S"].rstrip("f")) == known["tick_period_s"]
    assert int(told["MW_CONTROL_TICKS"].rstrip("u")) * known["tick_period_s"] == pytest.approx(
        known["control_period_s"]
    )
    assert float(told["MW_NODE_RANGE_V"].rstrip("f")) * known["divider_share"] == known["converter_range_v"]
    assert float(told["MW_SHUNT_RANGE_V"].rstrip("f")) * known["shunt_gain"] == known["converter_range_v"]


def test_a_wire_by_its_name_is_mounted_as_the_table_has_it_and_told_to_the_board(tmp_path: Path) -> None:
    mounted, own = mounted_wire("flexinol-0.15-lt"), own_circuit("flexinol-0.15-lt", wire_length_m=0.14)
    assert (mounted.shunt, mounted.pretension, mounted.legs) == (own.shunt_ohm, own.pretension_n, 2)
    assert (mounted.sense_voltage, mounted.drive_amplitude, mounted.maximum_voltage) == (
        own.sense_voltage_v,
        own.amplitude_v,
        own.maximum_v,
    )
    model = write_sources("arduino-uno", tmp_path, wire="flexinol-0.15-lt")
    assert model.wire["wire"] == "flexinol-0.15-lt"
    assert '"flexinol-0.15-lt"' in (tmp_path / "src" / "board_constants.h").read_text("utf-8")


def test_the_model_that_ships_for_a_catalogue_wire_is_the_simulated_one() -> None:
    shipped, again = load_model(MODELS / "flexinol-0.10-lt.json"), simulated_model(mounted_wire("flexinol-0.10-lt"))
    assert (again.resistance_min_ohm, again.resistance_max_ohm) == pytest.approx(
        (shipped.resistance_min_ohm, shipped.resistance_max_ohm), rel=1e-6
    )


def test_the_arduino_has_no_lockstep() -> None:
    with pytest.raises(CallerError, match="by the clock only"):
        EmulatedBoard(board="arduino-uno", pace="lockstep")
