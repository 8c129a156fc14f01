"""Steps that resolve nothing are an error of the numerics, friction that holds a warning: neither is a fault."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

FAULTS = ("wiring", "strand", "clamp", "resistance_")


def rig_file(folder: Path, text: str) -> Path:
    path = folder / "rig.toml"
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize(
    "text",
    [
        'sample_period = "1 s"\n[settings]\ntime_step_s = 1.0\n',
        'sample_period = "0.5 s"\nbench = "dead-weight"\nwire = "flexinol-0.025-ht"\npretension = "0.15 N"\n'
        "[settings]\ntime_step_s = 0.5\n",
    ],
    ids=["a step of 1 s", "a thin wire"],
)
def test_a_step_that_is_too_long_is_named_with_what_to_use(
    text: str, musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    answer = musclewire("characterize", rig_file(tmp_path, text), "-o", tmp_path / "loop.h5", "--cycles", "1")
    assert answer.code == 1
    (line,) = [line for line in answer.err.splitlines() if line.startswith("musclewire: the simulation")]
    assert "time_step_s" in line
    assert " ms" in line
    assert not any(word in answer.err for word in FAULTS)


def test_a_step_that_shows_is_a_warning_and_chosen_steps_resolve_a_sample_of_1_s(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    chosen = rig_file(tmp_path, 'sample_period = "1 s"\n')
    answer = musclewire("characterize", chosen, "-o", tmp_path / "chosen.h5", "--cycles", "1", "--json")
    assert answer.code == 0, answer.err
    assert answer.json["strain_gap_pct"] < 3.0
    path = rig_file(tmp_path, 'sample_period = "0.5 s"\n[settings]\ntime_step_s = 0.5\n')
    answer = musclewire("characterize", path, "-o", tmp_path / "loop.h5", "--cycles", "1", "--json")
    assert answer.code == 0, answer.err
    (warning,) = [text for text in answer.json["warnings"] if "steps" in text]
    assert "fixed steps of 500 ms" in warning


def test_friction_that_holds_the_wire_is_a_warning_on_stderr_and_in_the_document(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    path = rig_file(tmp_path, 'pretension = "0.5 N"\n[settings]\nguide_friction_n = "1 N"\n')
    first = ("--amplitude", "3.2 V", "--cycles", "1")  # no sweep before: what friction does to the first cycle
    answer = musclewire("characterize", path, "-o", tmp_path / "loop.h5", *first, "--json")
    assert answer.code == 1  # what comes back is no loop
    (warning,) = [text for text in answer.json["warnings"] if "friction" in text]
    assert warning.startswith("friction holds the wire")
    assert f"warning: {warning}" in answer.err


def test_a_rig_without_a_spring_prints_no_gap_of_force(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    path = rig_file(tmp_path, '[[load]]\npart = "weight"\nforce = "1.9 N"\n')
    answer = musclewire("characterize", path, "-o", tmp_path / "loop.h5", "--cycles", "1", "--json")
    assert answer.json["force_gap_pct"] is None
    assert "does not rise" in answer.json["no_force_gap"]
