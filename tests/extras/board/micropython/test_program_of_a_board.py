"""The program of a board with MicroPython: what is written, what is refused, and what it does when it is started."""

from __future__ import annotations

import ast
import socket
import time
from pathlib import Path

import numpy as np
import pytest
from emulation.board import EmulatedBoard, micropython_for, rig_file_text
from tests.extras.board.micropython.interpreters import require_interpreter

import musclewire as mw
from musclewire.errors import CallerError
from musclewire.experiment import control_on_board
from musclewire.extras.board import circuit_names, load_circuit, program_of, write_program

MODEL = Path(__file__).parents[4] / "firmware" / "models" / "paper-100um.json"
NAMES = ("filter", "inverse-model")


@pytest.mark.parametrize("board", circuit_names())
def test_every_board_has_a_whole_program(board: str) -> None:
    texts = program_of(board, "pico", MODEL, NAMES).texts
    assert list(texts)[-2:] == ["boot.py", "main.py"]
    for text in texts.values():
        ast.parse(text)
    assert f"BOARD = {board.encode()!r}" in texts["musclewire_numbers.py"]
    assert load_circuit(board).lowest_drive_v < 0.8


@pytest.mark.parametrize(
    ("board", "rig", "named"),
    [
        ("picoo", "pico", "did you mean 'pico'"),
        ("pico", "uno", "sense_voltage 0.3 V is less than"),
        ("pico", "simulated", "is no board on a serial line"),
    ],
)
def test_what_does_not_fit_is_refused(board: str, rig: str, named: str) -> None:
    with pytest.raises(CallerError, match=named):
        program_of(board, rig, None, NAMES)


def test_a_controller_without_a_form_there_is_refused() -> None:
    with pytest.raises(CallerError, match="fuzzy_tick, line 5 of it"):
        program_of("pico", "pico", MODEL, ("filter", "fuzzy-pid"))


def test_without_a_model_the_board_knows_no_estimator() -> None:
    texts = program_of("pico", "pico", None, NAMES).texts
    assert "filter_tick" not in texts["musclewire_rules.py"]
    assert "judged_sample" in texts["musclewire_rules.py"]


@pytest.mark.emulated
def test_the_board_closes_the_loop_by_itself_as_the_host_does(tmp_path: Path) -> None:
    require_interpreter()
    model = mw.load_model(MODEL)
    with EmulatedBoard(board="pico", pace="lockstep") as board:
        rig_file = tmp_path / "pico.toml"
        rig_file.write_text(rig_file_text("pico", "paper-100um", board.port_url, lockstep=True), encoding="utf-8")
        for loop in (mw.control, control_on_board):
            before = board.log()["strain"].size
            with mw.open_rig(rig_file, wire_temperature_k=295.15) as rig:
                run = loop(rig, model)  # type: ignore[operator]
            assert run.metrics.tracking_rms_pct < 6.0
            # The staircase ends upward at 3 %; the model was fitted on another circuit.
            assert board.log()["strain"][before:].max() == pytest.approx(0.03, rel=0.05)


@pytest.mark.emulated
def test_a_board_without_a_model_is_driven_by_its_host(tmp_path: Path) -> None:
    require_interpreter()
    program = micropython_for("pico", tmp_path)
    write_program(program_of("pico", "pico", None, NAMES).texts, program)
    with EmulatedBoard(board="pico", pace="lockstep", elf=program) as board:
        rig_file = tmp_path / "pico.toml"
        rig_file.write_text(rig_file_text("pico", "paper-100um", board.port_url, lockstep=True), encoding="utf-8")
        with mw.open_rig(rig_file, wire_temperature_k=295.15) as rig:
            samples = [rig.exchange(1.5) for _ in range(5)]
    ohm = [0.1 * sample.wire_voltage_v / sample.shunt_voltage_v for sample in samples]
    assert ohm == pytest.approx([17.3] * 5, rel=0.02)


@pytest.mark.emulated
def test_a_host_that_goes_at_any_moment_leaves_nothing_out_after_a_quarter_of_a_second(tmp_path: Path) -> None:
    require_interpreter()
    random = np.random.default_rng(66)
    with EmulatedBoard(board="pico", pace="lockstep") as board:
        rig_file = tmp_path / "pico.toml"
        rig_file.write_text(rig_file_text("pico", "paper-100um", board.port_url, lockstep=True), encoding="utf-8")
        for _ in range(10):
            rig = mw.open_rig(rig_file, wire_temperature_k=295.15)
            for _ in range(int(random.integers(1, 8))):
                rig.exchange(float(random.uniform(1.0, 3.0)))
            assert board.log()["code"][-1] > 0.0
            before = board.log()["code"].size
            board.unplug()
            board.release(8)
            # Expiry after 0.25 s without a command, of which a tick may just have begun.
            assert not board.log()["code"][before + 7 :].any()
            with pytest.raises(mw.RigError):
                rig.exchange(1.0)
            rig.close()
            board.plug()


@pytest.mark.emulated
def test_ctrl_c_ends_the_program_of_a_board_that_is_not_armed_and_the_wire_is_off() -> None:
    require_interpreter()
    with EmulatedBoard(board="pico") as board, socket.create_connection(("127.0.0.1", board.port)) as line:
        line.sendall(b"\r\x03")
        until = time.monotonic() + 10.0
        while "KeyboardInterrupt" not in board.messages() and time.monotonic() < until:
            time.sleep(0.05)
        assert "KeyboardInterrupt" in board.messages()
        assert board.log()["code"][-1] == 0.0


@pytest.mark.emulated
def test_a_file_that_is_not_whole_is_not_started(tmp_path: Path) -> None:
    require_interpreter()
    program = micropython_for("pico", tmp_path)
    (program / "musclewire_rules.py").write_text("cut", encoding="utf-8")
    with pytest.raises(mw.RigError, match=r"musclewire_rules.py is not as it was written"):
        EmulatedBoard(board="pico", elf=program).close()
