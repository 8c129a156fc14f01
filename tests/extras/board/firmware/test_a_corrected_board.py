"""The wire of today on an emulated board whose model is a hundredth off: corrected in mid-run as on the host."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from emulation.board import EmulatedBoard, firmware_for
from firmware.build import MODELS
from tests.extras.board.contract.serial_rigs import BOARD, COLD_K, PATIENCE_S, mounted
from tests.extras.board.firmware.conftest import ARM, STREAM, Host
from tests.tools import require_tool

from musclewire.controllers import sampled_reference
from musclewire.experiment import ControlRun, control, control_on_board
from musclewire.extras.board import MessageKind
from musclewire.rigs import open_rig
from musclewire.sensing import Correction, SensingModel, load_model, save_model

pytestmark = pytest.mark.emulated

# A hold: the board gets a target a sample before the loop on the host steps to it.
HOLD = sampled_reference([0.0, 3.0], [0.015, 0.015])
# After B, which scales, a strain that is known moves the zero.
KNOWN_STRAIN = (0.0155, 2.2)
# What single precision costs the filter in so short a run, in parts of the stroke.
SINGLE = 5e-4


def another_model(folder: Path) -> SensingModel:
    """Return the model of a wire that has a hundredth more resistance than the one on the bench; and save it."""
    model = Correction(1.0 / 1.01).applied_to(load_model(MODELS / "paper-100um.json"))
    save_model(model, folder / "model.json")
    return load_model(folder / "model.json")


def firmware_of(folder: Path, *options: str) -> Path:
    require_tool("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi")
    require_tool("qemu-system-arm", "qemu-system-arm")
    return firmware_for(BOARD, folder, ["--model", str(folder / "model.json"), *options])


def run_on(
    elf: Path, model: SensingModel, *, closed_by_board: bool, known_strain: tuple[float, float] | None = None
) -> ControlRun:
    asked: dict[str, Any] = {"zero_from": "today", "known_strain": known_strain}
    with EmulatedBoard(pace="lockstep", elf=elf) as board:
        on_port = mounted(board.port_url, patience=PATIENCE_S, lockstep=True)
        with open_rig(on_port, wire_temperature_k=COLD_K) as rig:
            if closed_by_board:
                return control_on_board(rig, model, HOLD, **asked)
            return control(rig, model, HOLD, estimator="filter", controller="inverse-model", **asked)


def test_the_same_run_on_host_and_board_agrees_up_to_and_after_the_corrections(tmp_path: Path) -> None:
    model = another_model(tmp_path)
    elf = firmware_of(tmp_path)
    host, board = (run_on(elf, model, closed_by_board=where, known_strain=KNOWN_STRAIN) for where in (False, True))
    scale = np.array(host["resistance_factor"])
    by_b, by_strain = np.flatnonzero(np.diff(scale)) + 1
    assert 10 < by_b < by_strain == 45
    assert scale[by_b] == pytest.approx(1.01, abs=1e-3)
    assert board["resistance_factor"] == pytest.approx(scale, abs=1e-6)
    assert np.array_equal(board["valid"], host["valid"])
    for column in ("estimated_strain", "estimate_std"):
        assert board[column] == pytest.approx(np.array(host[column]), abs=SINGLE * model.stroke)
    # The zero has moved the wire, and not what is followed.
    assert np.mean(board["estimated_strain"][-10:]) == pytest.approx(0.015, abs=2e-4)


def test_a_board_with_the_polynomial_estimates_by_the_corrected_model(tmp_path: Path) -> None:
    model = another_model(tmp_path)
    run = run_on(firmware_of(tmp_path, "--estimator", "polynomial"), model, closed_by_board=True)
    scale = float(run["resistance_factor"][-1])
    of_today = Correction(scale).applied_to(model)
    corrected = np.flatnonzero((np.array(run["resistance_factor"]) == scale) & (np.array(run["valid"]) > 0.0))
    assert scale == pytest.approx(1.01, abs=1e-3)
    assert corrected.size > 20
    for row in corrected:
        by_today = of_today.estimate(float(run["wire_resistance_ohm"][row])).value
        assert run["estimated_strain"][row] == pytest.approx(by_today, abs=1e-5)


def estimated_by(host: Host, scale: float) -> float:
    """Arm, correct if the scale is not 1, and return the estimate at a voltage that hardly heats."""
    assert host.command(ARM) == 0
    if scale != 1.0:
        assert host.command(MessageKind.CORRECT, struct.pack("<ff", scale, 0.0)) == 0
        assert struct.unpack("<ff", host.wait_for(MessageKind.CORRECTION)[-1]) == pytest.approx((scale, 0.0))
    before = len(host.samples())
    host.drive(1.0)
    host.wait_for(MessageKind.SAMPLE, before + 1)
    return host.samples()[-1].estimate


def test_a_reset_and_arming_forget_a_correction(elf: Path) -> None:
    with EmulatedBoard(elf=elf, pace="lockstep") as board:
        host = Host(board)
        host.command(STREAM, struct.pack("<H", 50))
        as_built, corrected, armed_again = (estimated_by(host, scale) for scale in (1.0, 0.95, 1.0))
        assert corrected > as_built + 0.01
        assert armed_again == pytest.approx(as_built, abs=5e-4)
        assert estimated_by(host, 0.95) > as_built + 0.01
        board.reset()
        host.command(STREAM, struct.pack("<H", 50))
        assert estimated_by(host, 1.0) == pytest.approx(as_built, abs=5e-4)
        host.close()
