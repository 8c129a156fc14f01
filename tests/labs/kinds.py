"""What importing makes of layouts that nobody has met: ``python -m tests.labs.kinds --count 2000 --seed 1``.

Each drawn file is imported as a person would; a ``try:`` line is typed as it is printed. The table says for each value
how many files that have it ended how:

right       every row that comes out is true, and at least 95 % of the measurements came out
by line     right by the ``try:`` line
part        what came out is true, a column is left out and named
clear       refused in one line that names what is unusual in the file
unclear     refused otherwise, or by the line that was to help
wrong       exit 0, and a number, a time or the number of rows is not true
traceback   an error that is no answer

It ends with 1 if a bar is missed, and names the bars.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from tests.command_line import Answer
from tests.labs.drawn_layouts import AXES, MARKS, MEASURED, Drawn, Truth, drawn
from tests.labs.layouts import TIME

import musclewire as mw
from musclewire.judge import judge_readings

Command = Callable[[Sequence[str]], Answer]
OUTCOMES = ("right", "by line", "part", "clear", "unclear", "wrong", "traceback")
# Shares that a reader is held to: of all files, of the files with one value.
MAX_WRONG, MAX_WRONG_OF_A_VALUE, MIN_RIGHT = 1 / 200, 1 / 50, 0.8
MIN_ROWS = 0.95
# Seconds that 2,000 files may take in one process.
MAX_S_OF_2000 = 600.0
# What a refusal has to name, by the axis on which a file is unusual or by the value itself: one of the words.
CAUSES = {
    "form": "name.{1,5}value|pairs|JSON|channel|signal", "suffix": r"'\.log'|'\.jsonl'", "separator": "separat",
    "decimal": "comma|decimal", "digits": "digits|steps|blank", "quotes": "quot", "line ends": "blank line|line end",
    "encoding": "encod|utf", "header": "lines above|preamble", "no names": "no headers|names", "names": "map|not known",
    "short": "never", "words": "never", "German": "never", "ours": "never", "quantities": "never", "units": "unit",
    "scale": "unit", "clock": "is the time|clock|stamp|not a time|period|tests are",
    "mark": "overload|missing|blank|mark|not a number", "beside": "empty|not known", "given": "unit|contradict",
    "readings": "far from|spike|alone|wrap|sign|negative|range|clipped|stays",
    "defect": "cut|last line|again|tests are|tables|gap|cells|'READY'",
}  # fmt: skip


def in_process(words: Sequence[str]) -> Answer:
    """Run one command in this process; an error that is no answer is printed as the interpreter would."""
    from musclewire.app import run

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = run([*words])
        except Exception:
            code = 1
            traceback.print_exc()
    return Answer(code, out.getvalue(), err.getvalue())


def by_command(words: Sequence[str]) -> Answer:
    """Run one command in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-P", "-m", "musclewire", *words], capture_output=True, text=True, check=False
    )
    return Answer(done.returncode, done.stdout, done.stderr)


def judged(recording: mw.Recording, truth: Truth) -> tuple[str, tuple[str, ...]]:
    """Return what is not true in a recording, or "", and the columns that it lacks."""
    columns = {name: recording[name] for name in recording.names}
    if extra := [name for name in MEASURED if name in columns and name not in truth.columns]:
        return f"{extra[0]} is not in the file", ()
    time_s, true_s = columns[TIME] - columns[TIME][0], truth.columns[TIME] - truth.columns[TIME][0]
    row = np.clip(np.searchsorted(true_s, time_s - 0.5 * np.diff(true_s).min()), 0, true_s.size - 1)
    off_s = np.abs(time_s - true_s[row])
    if not (off_s <= 2.0 * truth.tolerance[TIME]).all():
        return f"{TIME} is not true: {time_s.size} rows in {time_s[-1]:g} s, {true_s.size} in {true_s[-1]:g}", ()
    if (np.diff(row) <= 0).any():
        return f"rows came out twice: {time_s.size} in {time_s[-1]:g} s", ()
    found = [name for name in truth.columns if name in columns and name != TIME]
    usable = judge_readings(columns, recording.metadata).usable
    for name in found:
        error = np.abs(columns[name] - truth.columns[name][row])
        if (bad := usable & (error > 1.01 * truth.tolerance[name] + 1e-9 * np.abs(truth.columns[name]).max())).any():
            return f"{name} is not true in {bad.sum()} rows, by up to {error[bad].max():g}", ()
    whole = usable & ~np.isnan([columns[name] for name in found]).any(axis=0)
    share = (truth.kept[row] & whole).sum() / truth.kept.sum()
    if share < MIN_ROWS:
        return f"{share:.0%} of the measurements came out", ()
    began = str(recording.metadata.get("start_time", truth.day))
    if truth.day and not began.startswith(truth.day):
        return f"it began on {truth.day}, not at {began}", ()
    return "", tuple(name for name in truth.columns if name not in columns)


def best(truths: Sequence[Truth]) -> tuple[str, tuple[str, ...]]:
    """Return what is not true in what was written, and what it lacks: of several tests any one may have come out."""
    recording = mw.read_recording("out.h5")
    return min((judged(recording, truth) for truth in truths), key=lambda found: (bool(found[0]), len(found[1])))


def is_clear(answer: Answer, one: Drawn) -> bool:
    """Return whether a refusal is one line that names something that is unusual in the file."""
    # Before it stands what was seen in the file.
    refusals = [line for line in answer.err.splitlines() if line.startswith("musclewire: ")]
    unusual = [(axis, value) for axis, value in one.choice.items() if value != AXES[axis][0]]
    words = [CAUSES.get(value, CAUSES[axis]) for axis, value in unusual]
    words += [re.escape(MARKS[value]) for _, value in unusual if MARKS.get(value)]
    # A file's name names no cause.
    message = "".join(refusals).replace(one.name, "")
    return len(refusals) == 1 and any(re.search(word, message, re.IGNORECASE) for word in words)


def outcome(one: Drawn, command: Command) -> tuple[str, str]:
    """Return how importing one file ends, and all that it said."""
    Path(one.name).write_bytes(one.content)
    output = ("-o", "out.h5", "--overwrite")
    answer = command(["import", one.name, *one.given, *output])
    said = answer.out + answer.err
    if answer.code not in (0, 2) or "Traceback (" in said:
        return "traceback", said
    line = next((text.split("try: ", 1)[1] for text in said.splitlines() if "try: " in text), "")
    wrong, lacking = best(one.truths) if answer.code == 0 else ("", ())
    if answer.code == 0 and (wrong or not lacking):
        return ("wrong" if wrong else "right"), f"{said}{wrong}"
    if not line:
        return ("part" if answer.code == 0 else "clear" if is_clear(answer, one) else "unclear"), f"{said}{lacking}"
    again = command([*shlex.split(line)[1:], *output])
    said += again.out + again.err
    if again.code not in (0, 2) or "Traceback (" in said:
        return "traceback", said
    if again.code:
        return "unclear", said
    wrong, lacking = best(one.truths)
    return ("wrong" if wrong else "part" if lacking else "by line"), f"{said}{wrong}{lacking}"


Tally = dict[str, Counter[str]]


def tally_of(numbers: Sequence[int], seed: int, value: str = "", command: Command = in_process) -> Tally:
    """Return how many files ended how: of each value, and of all under ""."""
    found: Tally = {name: Counter() for name in ("", *(one for values in AXES.values() for one in values))}
    for number in numbers:
        one = drawn(seed, number, value)
        ended, _ = outcome(one, command)
        for name in ("", *one.choice.values()):
            found[name][ended] += 1
    return found


def missed(found: Tally) -> list[str]:
    """Return the bars that are missed."""
    every, count = found[""], found[""].total()
    lines = []
    if every["wrong"] > MAX_WRONG * count:
        lines.append(f"wrong with exit 0: {every['wrong']} of {count}, at most 1 in {1 / MAX_WRONG:.0f}")
    shares = {name: ends["wrong"] / ends.total() for name, ends in found.items() if name and ends.total()}
    if bad := sorted((name for name in shares if shares[name] > MAX_WRONG_OF_A_VALUE), key=lambda name: -shares[name]):
        lines.append(
            f"wrong more than 1 in {1 / MAX_WRONG_OF_A_VALUE:.0f}: with {len(bad)} values, most with {bad[:8]}"
        )
    if (right := every["right"] + every["by line"]) < MIN_RIGHT * count:
        lines.append(f"right at once or by the line: {right} of {count}, at least {MIN_RIGHT:.0%}")
    return lines + ([f"tracebacks: {every['traceback']}, none"] if every["traceback"] else [])


def table_of(found: Tally) -> str:
    """Return the table: of each value of each axis how many ended how."""
    rows = [("all", ""), *((axis, value) for axis, values in AXES.items() for value in values)]
    lines = [f"{'axis':<12}{'value':<38}{'files':>6}" + "".join(f"{name:>10}" for name in OUTCOMES)]
    for axis, value in rows:
        ends = found[value]
        lines.append(
            f"{axis:<12}{value:<38}{ends.total():>6}" + "".join(f"{ends[name] or '':>10}" for name in OUTCOMES)
        )
    return "\n".join(lines)


def shown(one: Drawn, command: Command) -> str:
    """Return one file's values, its first lines, and what importing said."""
    unusual = {axis: value for axis, value in one.choice.items() if value != AXES[axis][0]}
    head = "\n".join(re.split(r"[\r\n]+", one.content.decode(one.choice["encoding"]))[:14])
    ended, said = outcome(one, command)
    return f"{unusual}\n{one.name} {shlex.join(one.given)}\n{head}\n-> {ended}\n{said}"


def main() -> int:
    """Print the table and the bars that are missed."""
    options = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    options.add_argument("--count", type=int, default=2000)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--value", default="", choices=["", *(one for values in AXES.values() for one in values)])
    options.add_argument("--by-command", type=int, metavar="N", help="N files, each by processes of their own")
    options.add_argument("--show", type=int, metavar="NUMBER", help="print one file and what importing says")
    asked = options.parse_args()
    command, count = (in_process, asked.count) if asked.by_command is None else (by_command, asked.by_command)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        if asked.show is not None:
            print(shown(drawn(asked.seed, asked.show, asked.value), command))
            return 0
        began_s = time.perf_counter()
        found = tally_of(range(count), asked.seed, asked.value, command)
        took_s = time.perf_counter() - began_s
    bars = missed(found)
    if asked.by_command is None and took_s > MAX_S_OF_2000 * max(1.0, count / 2000):
        bars.append(f"{took_s:.0f} s for {count} files, at most {MAX_S_OF_2000:.0f} s for 2,000")
    print(table_of(found), f"{took_s:.0f} s", *(f"missed: {line}" for line in bars), sep="\n")
    return 1 if bars else 0


if __name__ == "__main__":
    raise SystemExit(main())
