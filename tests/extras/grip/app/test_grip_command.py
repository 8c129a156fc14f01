"""``musclewire grip``: what is typed, and what comes back."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.command_line import CommandLine

from musclewire.files import read_recording


@pytest.mark.slow
def test_a_grip_is_found_printed_recorded_and_drawn(musclewire: CommandLine, tmp_path: Path) -> None:
    learned = tmp_path / "learned.json"  # not there yet: the command trains the gripper
    answer = musclewire(
        "grip", "--known-stiffness", "200 N/m", "--learned", learned, "--plot", tmp_path / "grip.png",
        "-o", tmp_path / "grip.h5", "--json",
    )  # fmt: skip
    assert answer.code == 0, answer.err
    said = answer.json
    assert (said["contact"], said["held"], said["true_stiffness_n_per_m"]) == (True, True, 200.0)
    assert said["true_force_at_contact_n"] < 0.15
    assert said["error_n"] == pytest.approx(said["estimated_force_n"] - said["true_force_n"])
    assert abs(said["error_n"]) < 0.06
    (warning,) = said["warnings"]
    assert "above the vendor's 172 MPa" in warning
    assert (tmp_path / "grip.png").read_bytes().startswith(b"\x89PNG")
    assert read_recording(tmp_path / "grip.h5")["contact"].max() == 1.0
    assert learned.exists()


def test_with_the_object_away_nothing_is_found_and_the_exit_code_says_so(
    musclewire: CommandLine, learned: Path
) -> None:
    answer = musclewire("grip", "--no-object", "--learned", learned)
    assert answer.code == 1
    assert "no contact" in answer.out


def test_another_object_may_be_put_in(musclewire: CommandLine, learned: Path) -> None:
    said = musclewire(
        "grip", "--object-stiffness", "1 N/mm", "--clearance", "7 mm", "--learned", learned, "--seed", "4", "--json"
    ).json
    assert said["true_stiffness_n_per_m"] == pytest.approx(1000.0)
    assert said["opening_m"] == pytest.approx(7e-3, abs=0.5e-3)


def test_a_held_force_beyond_its_tolerance_ends_with_1(musclewire: CommandLine, learned: Path) -> None:
    known = ("grip", "--known-stiffness", "200 N/m", "--learned", learned)
    held = musclewire(*known, "--tolerance", "0.2 N")
    assert (held.code, "target 0.3 N" in held.out) == (0, True)
    answer = musclewire(*known, "--tolerance", "0.0001 N")
    assert answer.code == 1
    assert "the held force misses its target by" in answer.err


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("simulated", "nothing to grip"),
        ("--target 0N", "above 0"),
        ("--known-stiffness 200", "--known-stiffness: '200' has no unit"),
        ("--no-object --clearance 3mm", "--no-object"),
        ("--learned learned.txt", ".json"),
    ],
)
def test_what_cannot_be_gripped_is_refused_in_one_line(musclewire: CommandLine, typed: str, said: str) -> None:
    assert said in musclewire("grip", *typed.split()).refusal
