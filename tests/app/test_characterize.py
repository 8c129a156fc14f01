"""Slow loops from the command line: what is recorded, what is warned of, and what is said where there is no loop."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from tests.command_line import CommandLine

import musclewire as mw
from musclewire.files import read_recording
from musclewire.signals import Recording

# The minor loop of ``characterize`` as its user meets it: in the file, in a fit's number, and left out.

SHORT = ("--period", "30 s", "--cycles", "1")


def test_it_is_in_the_file_and_in_the_law_of_a_fit_and_nowhere_else(musclewire: CommandLine, tmp_path: Path) -> None:
    answers, laws = [], []
    for name, options in (("with.h5", ()), ("without.h5", ("--no-minor-loop",))):
        path = tmp_path / name
        answer = musclewire("characterize", "simulated", "-o", path, *SHORT, *options, "--json")
        assert answer.code == 0, answer.err
        fitted = musclewire("fit", path, "-o", path.with_suffix(".json"), "--json").json
        laws.append(fitted["wire_model"].pop("minor_loops"))
        answers.append((answer.json | {"recording": ""}, fitted | {"model": ""}))
    assert answers[0] == answers[1]
    assert [law["origin"] for law in laws] == [
        "minor loops of this recording",
        "any law is as likely: no minor loop shows it",
    ]
    assert laws[0]["std"] < laws[1]["std"]
    found, left_out = (mw.read_recording(tmp_path / name) for name in ("with.h5", "without.h5"))
    assert found.minor_loop is not None
    assert left_out.minor_loop is None
    assert len(found) == len(left_out) == answers[0][0]["samples"]


# A rig that measures no movement, as a board: a recording of it is what was asked for, not a failure.

PERIOD_S = 30.0
INSTRUMENTS = ("force_n", "displacement_m", "endpoint_displacement_m", "endpoint_force_n")


@pytest.fixture(scope="module")
def without_instruments(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rig file that replays a slow loop from which the instruments' columns are taken."""
    folder = tmp_path_factory.mktemp("rig")
    with mw.open_rig("simulated", seed=3) as rig:
        loop = mw.characterize(rig, period_s=PERIOD_S, cycles=1)
    kept = {name: values for name, values in loop.whole_columns.items() if name not in INSTRUMENTS}
    Recording(kept, loop.metadata).save(folder / "recorded.h5")
    (folder / "rig.toml").write_text('kind = "replay"\nrecording = "recorded.h5"\n', "utf-8")
    return folder / "rig.toml"


def test_a_perfect_run_without_an_instrument_ends_well_and_says_how_a_model_comes(
    without_instruments: Path, musclewire: CommandLine, tmp_path: Path
) -> None:
    output = tmp_path / "loop.h5"
    arguments = ("characterize", without_instruments, "-o", output, "--period", f"{PERIOD_S} s", "--cycles", "1")
    answer = musclewire(*arguments)
    assert answer.code == 0, answer.err
    assert "measures no movement" in answer.out
    assert "'musclewire fit' with --wire" in answer.out
    assert "displacement_m" in answer.out
    assert musclewire(*arguments, "--overwrite", "--json").json["strain_gap_pct"] is None


def test_a_recording_that_has_the_instrument_and_shows_no_loop_still_ends_with_one(
    musclewire: CommandLine, tmp_path: Path
) -> None:
    answer = musclewire("characterize", "simulated", "-o", tmp_path / "x.h5", "--amplitude", "0.4 V", "--period", "5 s")
    assert answer.code == 1
    assert answer.out.count("\n") == 2


# Steps that resolve nothing are an error of the numerics, friction that holds a warning: neither is a fault.

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
def test_a_step_that_is_too_long_is_named_with_what_to_use(text: str, musclewire: CommandLine, tmp_path: Path) -> None:
    answer = musclewire("characterize", rig_file(tmp_path, text), "-o", tmp_path / "loop.h5", "--cycles", "1")
    assert answer.code == 1
    (line,) = [line for line in answer.err.splitlines() if line.startswith("musclewire: the simulation")]
    assert "time_step_s" in line
    assert " ms" in line
    assert not any(word in answer.err for word in FAULTS)


def test_a_step_that_shows_is_a_warning_and_chosen_steps_resolve_a_sample_of_1_s(
    musclewire: CommandLine, tmp_path: Path
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
    musclewire: CommandLine, tmp_path: Path
) -> None:
    path = rig_file(tmp_path, 'pretension = "0.5 N"\n[settings]\nguide_friction_n = "1 N"\n')
    first = ("--amplitude", "3.2 V", "--cycles", "1")  # no sweep before: what friction does to the first cycle
    answer = musclewire("characterize", path, "-o", tmp_path / "loop.h5", *first, "--json")
    assert answer.code == 1  # what comes back is no loop
    (warning,) = [text for text in answer.json["warnings"] if "friction" in text]
    assert warning.startswith("friction holds the wire")
    assert f"warning: {warning}" in answer.err


def test_a_rig_without_a_spring_prints_no_gap_of_force(musclewire: CommandLine, tmp_path: Path) -> None:
    path = rig_file(tmp_path, '[[load]]\npart = "weight"\nforce = "1.9 N"\n')
    answer = musclewire("characterize", path, "-o", tmp_path / "loop.h5", "--cycles", "1", "--json")
    assert answer.json["force_gap_pct"] is None
    assert "does not rise" in answer.json["no_force_gap"]


# What a person typed and what the wire did is named in the answer: rigs, warnings, gaps.


def test_a_blocked_wire_is_recorded_with_a_warning_and_the_word_that_there_is_no_loop(
    musclewire: CommandLine, tmp_path: Any
) -> None:
    rig = tmp_path / "held.toml"
    rig.write_text('[[load]]\npart = "blocked"\n', "utf-8")
    call = ("characterize", rig, "-o", tmp_path / "held.h5", "--cycles", "1", "--period", "30 s")
    answer = musclewire(*call)
    assert answer.code == 1
    assert "no loop: the part 'blocked' holds the wire" in answer.out
    pull_n = read_recording(tmp_path / "held.h5")["force_n"].max()
    assert f"warning: the wire pulls with up to {pull_n:.2f} N" in answer.err
    document = musclewire(*call, "--overwrite", "--json").json
    assert [text for text in document["warnings"] if "allowed (maximum_force_n" in text] == document["warnings"][:1]
    assert document["strain_gap_pct"] is document["stroke_pct"] is None
    refused = musclewire("fit", tmp_path / "held.h5", "--quantity", "force")
    assert refused.code == 2
    assert "there is nothing to fit" in refused.err


def test_characterize_shows_every_gap_and_that_of_a_fingers_endpoint(musclewire: CommandLine, tmp_path: Any) -> None:
    short = ("--cycles", "1", "--period", "40 s")
    finger = musclewire("characterize", "finger", "-o", tmp_path / "finger.h5", *short).out
    assert all(f"{name} gap" in finger for name in ("strain", "displacement", "force"))
    spring = musclewire("characterize", "simulated", "-o", tmp_path / "spring.h5", *short).out
    assert "strain gap" in spring
    assert "displacement gap" not in spring


def test_a_sweep_warns_on_stderr_and_in_json(musclewire: CommandLine, tmp_path: Any) -> None:
    rig = tmp_path / "stiff.toml"
    rig.write_text('[[load]]\npart = "spring"\nstiffness = "2000 N/m"\n', "utf-8")
    answer = musclewire(
        "pretension", rig, "--at", "0.5 N", "--at", "3 N", "--cycles", "1", "--period", "60 s", "--json"
    )
    assert (answer.code, answer.json["best_pretension_n"]) == (1, None)
    assert answer.json["advice"].startswith("no pretension of these is within the wire's limit")
    (warning,) = [text for text in answer.json["warnings"] if "allowed (maximum_force_n" in text]
    assert warning.startswith("pretension 3 N: the wire pulls with up to ")
    assert f"warning: {warning}" in answer.err


def test_a_staircase_is_answered_in_the_unit_in_which_it_was_asked_for(musclewire: CommandLine, model: Any) -> None:
    def refusal(reference: str) -> str:
        return str(musclewire("control", "simulated", model, "--reference", reference).refusal)

    assert "the reference goes from 0.5 to 6 %, but this model senses strain only from" in refusal(
        "0.5 % to 6 % by 0.6 %"
    )
    assert refusal("1 % to 3 % by 0.6 %").endswith("from 1 % to 3 %: increments of 0.6 % miss the stop; try 0.666667 %")


# A key of rig files, or a part of a load, that a part offers by its manifest: without that one line names the part.

# Parts are looked for once, when rigs are first asked for.
WITHOUT_PARTS = """
import sys
import musclewire.manifest as parts
parts.own_manifests = lambda: iter(())
from musclewire.app import run
print([run(["doctor", file]) for file in sys.argv[1:]])
"""
KEYS = {"instruments": '[[fault]]\nkind = "wire_open"', "grip": '[[load]]\npart = "antagonist"'}


def test_a_key_of_a_part_that_is_not_there_is_one_line_that_names_the_part(tmp_path: Path) -> None:
    files = {part: tmp_path / f"{part}_rig.toml" for part in KEYS}
    for part, file in files.items():
        file.write_text(KEYS[part], "utf-8")
    given = [sys.executable, "-c", WITHOUT_PARTS, *map(str, files.values())]
    done = subprocess.run(given, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [str([2] * len(files))]
    for (part, file), said in zip(files.items(), done.stderr.splitlines(), strict=True):
        assert f"belongs to the part '{part}'" in said
        assert str(file) in said
