"""The command import: a preview is what writing does, mappings are remembered, messages do not advise what was done."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import musclewire as mw

FOREIGN = "Zeit;Vw;Strom [mA];Feuchte\n0,0;300,1;17,2;40\n0,1;300,4;17,3;41\n0,2;300,9;17,4;40\n"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "mine.csv"
    path.write_text(FOREIGN)
    return path


def test_a_mapping_is_proposed_completed_remembered_and_used_again(
    file: Path, tmp_path: Path, musclewire: Callable[..., Any]
) -> None:
    proposed = musclewire("import", file)
    assert proposed.code == 2
    assert "'Zeit' undecided" in proposed.out
    assert "'Vw' ignored: name not known" in proposed.out
    assert "map it: time_s=Zeit:s" in proposed.err
    saved = musclewire(
        "import", file, "-c", "time_s=Zeit:s", "-c", "wire_voltage_v=Vw:mV", "--save-mapping", tmp_path / "m.toml"
    )
    assert saved.code == 0, saved.err
    assert "wire_voltage_v: 0.3001 to 0.3009 V" in saved.out
    again = musclewire("import", file, "--mapping", tmp_path / "m.toml", "-o", tmp_path / "mine.h5")
    assert again.code == 0, again.err
    assert mw.read_recording(tmp_path / "mine.h5")["wire_current_a"] == pytest.approx([0.0172, 0.0173, 0.0174])


def test_a_sample_period_is_the_clock_of_a_file_without_one(file: Path, musclewire: Callable[..., Any]) -> None:
    counted = musclewire("import", file, "--ignore", "Zeit", "--sample-period", "10 ms", "--json")
    assert counted.json["files"][0]["ranges"]["time_s"] == pytest.approx([0.0, 0.02])
    both = musclewire("import", file, "-c", "time_s=Zeit:s", "--sample-period", "10 ms")
    assert both.code == 2
    assert "has a clock, column 'Zeit', and a sample period was given" in both.err
    assert "--sample-period" not in both.err


def test_what_is_ignored_has_to_be_there(file: Path, musclewire: Callable[..., Any]) -> None:
    assert (
        "no column 'Feucht' to ignore; did you mean 'Feuchte'?" in musclewire("import", file, "--ignore", "Feucht").err
    )
    both = musclewire("import", file, "--ignore", "Zeit", "-c", "time_s=Zeit:s")
    assert "'Zeit' is both mapped to time_s and taken or ignored" in both.err


def test_nothing_is_written_of_a_file_that_cannot_be_used(
    file: Path, tmp_path: Path, musclewire: Callable[..., Any]
) -> None:
    file.write_text(FOREIGN.replace("300,9", "x1"))
    given = ("-c", "time_s=Zeit:s", "-c", "wire_voltage_v=Vw:mV")
    preview, written = (musclewire("import", file, *given, *more) for more in ((), ("-o", tmp_path / "mine.h5")))
    assert preview.code == written.code == 2
    # A preview has what was seen on stdout.
    assert written.err == preview.out + preview.err
    assert not (tmp_path / "mine.h5").exists()


def test_of_a_file_with_a_problem_json_is_one_document_that_says_it(file: Path, musclewire: Callable[..., Any]) -> None:
    answer = musclewire("import", file, "--json")
    assert answer.code == 2
    assert answer.json["files"][0]["problem"] in answer.err
    assert answer.json["files"][0]["undecided"][0]["header"] == "Zeit"


def test_two_loggers_are_joined_and_the_delay_is_reported(tmp_path: Path, musclewire: Callable[..., Any]) -> None:
    time_s = np.arange(0.0, 20.0, 0.02)
    for name, delay_s, header in (("a.csv", 0.0, "Current [A]"), ("b.csv", 2.5, "Force [N]")):
        pulse = ((time_s - delay_s > 7.3) & (time_s - delay_s < 9.0)) * 3.0
        rows = [f"{one:.2f},{two},{one}\n" for one, two in zip(time_s, pulse, strict=True)]
        (tmp_path / name).write_text(f"Time [s],Drive [V],{header}\n" + "".join(rows))
    joined = musclewire("import", tmp_path / "a.csv", tmp_path / "b.csv", "-o", tmp_path / "loop.h5", "--json")
    assert joined.code == 0, joined.err
    assert joined.json["join"]["delay_s"] == pytest.approx(2.5, abs=3.0 * joined.json["join"]["delay_std_s"])
    loop = mw.read_recording(tmp_path / "loop.h5")
    assert loop.names == ("time_s", "drive_voltage_v", "wire_current_a", "force_n")
    assert loop["force_n"] - loop["time_s"] == pytest.approx(2.5, abs=0.05)
    assert "takes two files, 1 were given" in musclewire("import", tmp_path / "a.csv", "--join", "force_n").err


@pytest.mark.parametrize(
    ("head", "row", "said"),
    [
        ("time [s],wire_voltage_v,shunt_voltage_v", "{t},nan,nan", "only the time is usable"),
        ("time [s],drive_voltage_v,wire_voltage_v,shunt_voltage_v", "{t},1,nan,nan", "'wire_voltage_v' has no number"),
        ("time [s],wire_voltage_v,displacement_m", "{t},,0.001", "'wire_voltage_v' has no number"),
        ("time [s],wire_voltage_v,shunt_voltage_v", "{t},1.2,0.1", "nothing states the shunt's resistance"),
        ("time [s],wire_voltage_v,wire_current_a", "{t},1.2,0", "wire_current_a is 0 in every row"),
    ],
)
def test_a_recording_without_electricity_is_not_converted(
    head: str, row: str, said: str, musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    file = tmp_path / "logged.csv"
    file.write_text("\n".join([head, *(row.format(t=0.05 * number) for number in range(5))]) + "\n", "utf-8")
    answer = musclewire("import", file, "-o", tmp_path / "out.h5")
    assert answer.code == 2
    assert said in answer.err
    assert [path.name for path in tmp_path.iterdir()] == ["logged.csv"]


def test_of_the_voltage_of_a_shunt_the_preview_says_that_converting_needs_its_resistance(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    file = tmp_path / "logged.csv"
    file.write_text("time [s],wire_voltage_v,shunt_voltage_v\n0,1.2,0.1\n1,1.3,0.1\n", "utf-8")
    seen = musclewire("import", file)
    assert (seen.code, "nothing states the shunt's resistance" in seen.out) == (0, True)
    assert musclewire("import", file, "--shunt", "1 ohm", "-o", tmp_path / "out.h5").code == 0


@pytest.mark.parametrize(
    ("command", "clock"),
    [
        ("import FILE -o out.h5", "Zeit"),
        ("fit FILE -o out.json", "Time [s]"),
        ("estimate MODEL FILE -o out.h5", "Time [s]"),
    ],
)
def test_what_was_seen_in_a_refused_file_stands_before_the_refusal_and_the_command_itself_reads_it(
    command: str,
    clock: str,
    model: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    musclewire: Callable[..., Any],
) -> None:
    monkeypatch.chdir(tmp_path)
    with mw.open_rig("simulated", seed=2) as rig:
        loop = mw.characterize(rig, cycles=1)
    names = ("time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m")
    rows = np.column_stack([loop[name] for name in names])
    np.savetxt("mine.csv", rows, delimiter=",", header=f"{clock},a [V],b [V],Laser [m]", comments="")
    words = [str(model) if word == "MODEL" else word.replace("FILE", "mine.csv") for word in command.split()]
    given = ("--leg-length", "70 mm", "--shunt", "1 ohm")
    refused = musclewire(*words, *given)
    seen = musclewire("import", "mine.csv", *given).out
    *said, last = refused.err.splitlines()
    assert (refused.code, refused.out) == (2, "")
    assert last.startswith("musclewire: ")
    assert "\n".join(said).startswith(seen.split("\n  try:")[0])
    (line,) = (text.removeprefix("  try: ") for text in said if text.startswith("  try: "))
    assert line.startswith(f"musclewire {shlex.join(words)} ")
    assert not (tmp_path / words[-1]).exists()
    assert musclewire(*shlex.split(line)[1:]).code == 0
    assert (tmp_path / words[-1]).exists()


def test_a_fit_takes_the_options_of_import_and_names_import_where_it_could_not_end_well_itself(
    file: Path, musclewire: Callable[..., Any]
) -> None:
    given = ("--ignore", "Zeit", "--sample-period", "10 ms", "--drop-missing", "-c", "wire_voltage_v=Vw:mV")
    assert "strain" in musclewire("fit", file, *given).refusal
    said = musclewire("fit", file).err
    assert f"  try: musclewire import {file} -c time_s=Zeit:s" in said
    assert "\n  (fit needs more: " in said


def test_of_two_files_that_are_to_be_joined_the_refused_one_is_shown(
    file: Path, tmp_path: Path, musclewire: Callable[..., Any]
) -> None:
    other = tmp_path / "other.csv"
    other.write_text("Time [s],Force [N]\n0,1\n0.1,2\n0.2,1\n", "utf-8")
    refused = musclewire("import", other, file, "-o", tmp_path / "joined.h5")
    assert (refused.code, refused.out) == (2, "")
    assert refused.err.startswith(f"{file}: text, separated by semicolons")
    assert f"\n  try: musclewire import {file} -c time_s=Zeit:s" in refused.err
