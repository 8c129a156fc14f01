"""Follows the front doors of the documentation to the letter, in a clone of the last commit, and judges their ends.

Every ``sh`` and ``python`` block of README and of a door's pages runs in the order in which it is read, in one shell,
and must succeed. A block that begins with "# second terminal" gets a shell of its own; the next one waits until it has
printed something, as a reader would. An indented line below a block is what it prints: it must occur in what it
printed. What installs is left out, for the environment is that of the tests, and so is the README's second command.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

from tests.places import CHECKOUT

SECOND = "# second terminal"
SET_UP = ("python3 -m venv", "apt-get ")
PART = re.compile(r"^```(sh|python)\n(.*?)^```$|^((?: {4}[^\n]*\n)+)", re.M | re.S)
DONE = "==this block has ended=="


def patient(text: str) -> str:
    """Return a block in which the doctor is asked up to three times more, later and later, while it finds something.

    On a machine that does other things it finds samples that come late, and says to reduce the load.
    """
    once_more = "".join(rf" || {{ sleep {pause_s}; \g<0>; }}" for pause_s in (10, 30, 60))
    return re.sub(r"^musclewire doctor \S+$", r"\g<0>" + once_more, text, flags=re.M)


class NotFollowedError(Exception):
    """A door cannot be followed as it is written."""


@dataclass(frozen=True)
class Door:
    """Pages in the order in which they are read after README, and a program that judges their end."""

    pages: tuple[str, ...]
    end: str


MOVED = """
import numpy as np
import musclewire as mw
run = mw.read_recording({file!r})
assert run.metadata["ended"] == "done", run.metadata["ended"]
last = run["time_s"] > run["time_s"][-1] - 2.0  # of a step of 6 s, whatever the sample period
away = 100 * np.abs(run["estimated_strain"] - run["target_strain"])[last]
print(f"the end: {{len(run)}} samples of a closed loop; estimate off the target by {{np.median(away):.3f}} % (median)")
assert np.median(away) < 0.1, "the wire was not where it was asked to be"
"""
MODELS = """
import musclewire as mw
for name in ("labview", "logger"):
    model = mw.load_model(f"{name}.json")
    strain = 0.5 * (model.quantity_min + model.quantity_max)
    resistance_ohm = model.resistance_ohm(strain)
    print(f"the end: model of {name}: {100 * strain:.2f} % strain at {resistance_ohm:.3f} ohm")
    assert abs(model.strain(resistance_ohm) - strain) < 1e-3, "the model does not invert"
"""
DOORS = {
    "loop": Door(("docs/tutorials/the_basic_loop.md",), MOVED.format(file="run.h5")),
    "maker": Door(("docs/start/maker.md",), MOVED.format(file="moved.h5")),
    "lecturer": Door(("docs/start/lecturer.md",), MOVED.format(file="still.h5")),
    "researcher": Door(("docs/start/researcher.md",), MODELS),
}


@dataclass(frozen=True)
class Block:
    """What a reader types, and the lines that the page says it prints."""

    page: str
    language: str
    text: str
    prints: tuple[str, ...] = ()


def blocks_of(page: str) -> list[Block]:
    """Return the blocks of a page in their order, each with the indented lines that follow it."""
    found: list[Block] = []
    for language, text, printed in PART.findall((CHECKOUT / page).read_text("utf-8")):
        if language:
            found.append(Block(page, language, text))
        elif found:
            lines = tuple(" ".join(line.split()) for line in printed.splitlines() if line.strip())
            found[-1] = Block(page, found[-1].language, found[-1].text, found[-1].prints + lines)
    return found


class Terminal:
    """A shell in a clone, with the environment of this Python in the place of ``.venv``."""

    def __init__(self, home: Path) -> None:
        """Start it in the clone below ``home``."""
        self.home, self.count = home, 0
        path = [folder for folder in os.environ["PATH"].split(os.pathsep) if folder != f"{sys.prefix}/bin"]
        self.process = subprocess.Popen(
            ["bash"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env={**os.environ, "PATH": os.pathsep.join(path), "COLUMNS": "120"},
            start_new_session=True,
        )
        self.say(f"set -e; cd {home}/musclewire")

    def say(self, line: str) -> None:
        """Type a line."""
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def begin(self, block: Block) -> None:
        """Type a block: it is read from a file, so that no program in it reads the blocks after it."""
        self.count += 1
        file = self.home / f"{id(self):x}_{self.count}.{'py' if block.language == 'python' else 'sh'}"
        file.write_text(patient(block.text), encoding="utf-8")
        run = ".venv/bin/python" if block.language == "python" else "."
        self.say(f"{run} {file} </dev/null; echo '{DONE}'")

    def lines(self) -> Iterator[str]:
        """Yield what it prints, line by line, until the block has ended."""
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if line.strip() == DONE:
                return
            print(f"    {line}", end="", flush=True)
            yield line
        raise NotFollowedError(f"ended with exit code {self.process.wait()}")

    def first_line(self) -> None:
        """Wait until it has printed something."""
        if next(self.lines(), None) is None:
            raise NotFollowedError("ended without printing anything")

    def close(self) -> None:
        """End the shell and everything that it has started."""
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, 15)
        with suppress(BrokenPipeError):
            self.process.communicate()


def follow(door: Door, home: Path) -> None:
    """Follow a door in a clone. Raises NotFollowedError with the block that failed."""
    type_in_a_clone([block for page in ("README.md", *door.pages) for block in blocks_of(page)], door.end, home)


def own_wire(wire: str, period: str, reference: str) -> list[Block]:
    """Return the door's way with another wire of the catalogue: from the table to a closed loop on the emulated Uno."""
    load = 'spring_stiffness_n_per_m="588.6 N/m"'
    typed = (
        'musclewire simulate --table --wire-length "140 mm"',
        f"{SECOND}\npython -m emulation.board --board arduino-uno --wire {wire} --rig-file board.toml",
        "musclewire doctor board.toml",
        f'musclewire characterize board.toml --cycles 1 --period "{period}" -o loop.h5',
        f"musclewire fit loop.h5 --wire {wire} -o model.json --set {load}",
        f'musclewire control board.toml model.json -o moved.h5 --reference "{reference}"',
    )
    begin = ". .venv/bin/activate"
    return [
        Block(wire, "sh", f"{SECOND}\n{begin}\n{text}\n" if text.startswith(SECOND) else f"{begin}\n{text}\n")
        for text in typed
    ]


def type_in_a_clone(blocks: Sequence[Block], end: str, home: Path) -> None:
    """Type blocks one after the other in a clone, then judge their end. Raises NotFollowedError as ``run``."""
    subprocess.run(["git", "clone", "-q", "--no-hardlinks", str(CHECKOUT), str(home / "musclewire")], check=True)
    (home / "musclewire/.venv").symlink_to(sys.prefix)
    with ExitStack() as stack:
        first = Terminal(home)
        stack.callback(first.close)
        for block in blocks:
            if any(word in block.text for word in SET_UP):
                continue
            if block.text.startswith(SECOND):
                second = Terminal(home)
                stack.callback(second.close)
                second.begin(block)
                second.first_line()
            else:
                run(first, block)
        run(first, Block("the end", "python", end))


def run(terminal: Terminal, block: Block) -> None:
    """Run a block in a terminal and hold what it printed to what the page says it prints."""
    text = "".join(line + "\n" for line in block.text.splitlines() if "-m pytest" not in line)
    terminal.begin(Block(block.page, block.language, text))
    lines: list[str] = []
    try:
        for line in terminal.lines():
            lines.append(" ".join(line.split()))
    except NotFollowedError as error:
        refused = "; ".join(line for line in lines if line.startswith(("NO ", "musclewire: ")))
        raise NotFollowedError(f"{block.page}: {error}: {text.strip()}: {refused or lines[-1:]}") from error
    said = "\n".join(lines)
    for line in block.prints:
        if line not in said:
            raise NotFollowedError(f"{block.page} says that this is printed, and it is not: {line}")
