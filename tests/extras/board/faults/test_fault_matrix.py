"""Every row of the fault matrix: injected into the real thing, ended in its stated time, recorded with its cause.

Judged by the bench's own log of what was at the wire. A busy machine can end a run that nothing was done to, by late
samples: such a run proves nothing either way and is tried again, five times in all; then the test fails.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest
from emulation.board import EmulatedBoard
from tests.extras.board.contract.serial_rigs import built_firmware, mounted, require_board
from tests.extras.board.faults.injecting import SOUND_SAMPLES, Outcome, command_run, judged_s, scripted_run
from tests.faults.table import FaultRow, fault_matrix

from musclewire.errors import RigError
from musclewire.extras.board._serial import board as board_module
from musclewire.extras.board._serial import frames
from musclewire.extras.board._serial.message_types import PROTOCOL_VERSION
from musclewire.files import read_recording
from musclewire.rigs import open_rig

MATRIX = fault_matrix()
ATTEMPTS = 5
# What a machine that is busy elsewhere does to a run by itself.
BY_A_BUSY_MACHINE = ("sample_late", "command_missing", "device_lost")
LOCKSTEP_PATIENCE_S, CLOCK_PATIENCE_S = 15.0, 0.25
Boards = Callable[[str], EmulatedBoard]


# Of the faults tried on the firmware in its emulator, those that every run of the tests tries.
ALWAYS = ("a bridge of 4 ohm over the wire", "a script raises an exception")
# What takes a command of its own, or minutes where the machine is busy: of these CI tries a signal and a killed host.
# And what is near another row: a bridge of 4 ohm, the other channel, bytes that are corrupted both ways.
IN_FULL = (
    "the two channels are swapped",
    "the converter repeats itself inside the firmware",
    "a dead short over the wire",
    "the shunt's channel is frozen",
    "the shunt's channel stands at the end of its range",
    "50 % of the bytes to the board are corrupted",
    "50 % of the bytes from the board are corrupted",
)
COMMANDS_IN_CI = ("Ctrl-C", "the host is killed (SIGKILL)")


def rows(*runs: str) -> list[pytest.ParameterSet]:
    chosen = [row for row in MATRIX if row.run in runs and row.inject != "other version"]
    return [pytest.param(row, id=row.name, marks=group_of(row)) for row in chosen]


def group_of(row: FaultRow) -> Sequence[pytest.MarkDecorator]:
    if row.name in IN_FULL or (row.run == "command" and row.name not in COMMANDS_IN_CI):
        return (pytest.mark.full,)
    return () if row.run == "simulated" or row.name in ALWAYS else (pytest.mark.emulated,)


@pytest.fixture(scope="module")
def boards() -> Iterator[Boards]:
    """Boards that are used again, one at a time."""
    require_board()
    made: dict[str, EmulatedBoard] = {}

    def board(pace: str) -> EmulatedBoard:
        for other in set(made) - {pace}:
            made.pop(other).close()
        if pace not in made:
            made[pace] = EmulatedBoard(pace=pace, elf=built_firmware(fault_injection=True))  # type: ignore[arg-type]
        return made[pace]

    yield board
    for one in made.values():
        one.close()


def mended(board: EmulatedBoard, row: FaultRow) -> None:
    """Undo a fault, so that the board serves the next one."""
    board.repair()
    board.spoil_line()
    board.plug()
    if row.inject in ("power cut", "firmware", "reset"):
        board.restart()
    if row.inject == "flood":
        time.sleep(1.0)  # what is still on the line


def in_vain(outcome: Outcome, row: FaultRow) -> bool:
    """Whether a busy machine has ended the run before its fault came, or by lateness instead of it."""
    if row.inject != "from the start" and not outcome.injected:
        return True
    if not outcome.said or any(event in outcome.said for event in row.event):
        return False
    # A board that gets its conversions late measures what was out before: to it, an output that does not follow.
    return outcome.bench_was_late or any(event in outcome.said for event in BY_A_BUSY_MACHINE)


def ticks_lost(board: EmulatedBoard) -> int:
    """Return how many ticks the bench has given up, or their conversions, because it or the emulator had to wait."""
    figures = board.figures()
    return int(figures["given_up"] + figures["overwritten"])


def tried(run: Callable[[], Outcome], row: FaultRow) -> Outcome:
    outcome = run()
    for _ in range(ATTEMPTS - 1):
        if not in_vain(outcome, row):
            break
        time.sleep(1.0)
        outcome = run()
    return outcome


def test_the_matrix_has_at_least_thirty_faults_and_each_row_has_its_own_name() -> None:
    assert len(MATRIX) >= 30
    assert len({row.name for row in MATRIX}) == len(MATRIX)
    assert {row.where for row in MATRIX} == {"wire", "circuit", "converter", "line", "board", "host"}


@pytest.mark.parametrize("row", rows("lockstep", "clock"))
def test_a_fault_in_a_script_s_run(boards: Boards, row: FaultRow, tmp_path: Path) -> None:
    board = boards(row.run)
    patience_s = LOCKSTEP_PATIENCE_S if row.run == "lockstep" else CLOCK_PATIENCE_S
    attempts = iter(range(ATTEMPTS))

    def run() -> Outcome:
        lost = ticks_lost(board)
        found = scripted_run(board, row, tmp_path / f"run{next(attempts)}.h5", patience_s)
        found.bench_was_late = ticks_lost(board) > lost
        found.off_s = judged_s(board, found.since, row)  # type: ignore[attr-defined]
        mended(board, row)
        return found

    outcome = tried(run, row)
    assert outcome.recording is not None, outcome.said
    assert len(outcome.recording) >= (0 if row.inject == "from the start" else SOUND_SAMPLES)
    if row.survived:
        assert outcome.error is None, outcome.said
        assert outcome.ended == "done"
        return
    assert outcome.error is not None, "the fault was not noticed"
    assert any(event in outcome.said for event in row.event), outcome.said
    # A refused command is recorded by its own words.
    causes = (*row.event, "is outside 0 to") if "command_refused" in row.event else row.event
    assert any(event in outcome.ended for event in causes), outcome.ended
    assert outcome.off_s <= row.within_s, outcome.said  # type: ignore[attr-defined]
    if row.exit == "3":
        assert outcome.exit_code == 3, outcome.said


@pytest.mark.parametrize("row", rows("command"))
def test_a_fault_in_a_command_s_run(boards: Boards, row: FaultRow, tmp_path: Path) -> None:
    board = boards("clock")
    attempts = iter(range(ATTEMPTS))

    def run() -> Outcome:
        folder = tmp_path / str(next(attempts))
        folder.mkdir()
        lost = ticks_lost(board)
        found = command_run(board, row, folder)
        found.bench_was_late = ticks_lost(board) > lost
        found.off_s = judged_s(board, found.since, row)  # type: ignore[attr-defined]
        mended(board, row)
        found.path = folder / "loop.h5"  # type: ignore[attr-defined]
        return found

    outcome = tried(run, row)
    assert outcome.off_s <= row.within_s, outcome.said  # type: ignore[attr-defined]
    if row.exit == "-":  # killed: only the board is left
        assert outcome.exit_code is not None
        assert outcome.exit_code < 0
        return
    assert outcome.exit_code == int(row.exit), outcome.said
    assert any(event in outcome.said for event in row.event), outcome.said
    assert len(outcome.said.strip().splitlines()) <= 4, outcome.said
    recording = read_recording(outcome.path)  # type: ignore[attr-defined]
    assert len(recording) >= SOUND_SAMPLES
    assert recording.metadata["ended"] not in (None, "", "done")


@pytest.mark.emulated
def test_another_version_of_the_protocol_is_refused_before_anything_is_driven(
    boards: Boards, monkeypatch: pytest.MonkeyPatch
) -> None:
    row = next(row for row in MATRIX if row.inject == "other version")
    board = boards("clock")
    since = time.monotonic()
    with monkeypatch.context() as other:
        other.setattr(frames, "PROTOCOL_VERSION", PROTOCOL_VERSION + 1)
        other.setattr(board_module, "PROTOCOL_VERSION", PROTOCOL_VERSION + 1)
        with pytest.raises(RigError, match=r"version|no answer"):
            open_rig(mounted(board.port_url, patience=CLOCK_PATIENCE_S, limits=row.limits))
    assert judged_s(board, since, row) == 0.0
