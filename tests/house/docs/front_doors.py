"""Follows the front doors of the documentation to the letter, in clones of the last commit, and judges their ends.

    python3 -m tests.house.docs.front_doors [--environment .venv] [DOOR ...]

The environment is one that README's first command alone has made: without ``--environment`` that command makes one.
Every ``sh`` and ``python`` block of a door's pages runs in the order in which it is read, in one shell, and must
succeed: what installs, too, as root where the page says so. A block that begins with "# second terminal" gets a shell
of its own; the next one waits until it has printed something, as a reader would. An indented line below a block is what
it prints: it must occur in what it printed. README's second command is left out: no door needs it.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

from tests.places import CHECKOUT

SECOND = "# second terminal"
PART = re.compile(r"^```(sh|python)\n(.*?)^```$|^((?: {4}[^\n]*\n)+)", re.M | re.S)
DONE = "==this block has ended=="


def patient(text: str) -> str:
    """Return a block in which the doctor is asked up to three times more, later and later, while it finds something.

    On a machine that does other things it finds samples that come late, and says to reduce the load.
    """
    once_more = "".join(rf" || {{ sleep {pause_s}; \g<0>; }}" for pause_s in (10, 30, 60))
    return re.sub(r"^musclewire doctor \S+$", r"\g<0>" + once_more, text, flags=re.M)


def as_typed(text: str) -> str:
    """Return a block as the shell gets it: root's lines as root, and without what has made the environment."""
    if "apt-get " in text and os.geteuid() != 0:
        text = re.sub(r"^apt-get ", "sudo apt-get ", text, flags=re.M)
    return patient("".join(f"{line}\n" for line in text.splitlines() if ".venv/bin/pip" not in line))


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
PAGE_STOPS = """
import re
import subprocess
import musclewire as mw
command = [".venv/bin/musclewire", "serve", "--port", "18765"]
server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
address = next(found[0] for line in server.stdout if (found := re.search(r"http://[0-9.:]+", line)))
with mw.LiveClient(address) as client:
    bench = client.wait_for("ready", "off")
    print("the end: the live page's bench is", bench["phase"], "and answers a stop with", client.stop())
server.terminate()
server.wait(timeout=30)
"""
README_RUN = """
import musclewire as mw
print("the end:", mw.read_recording("run.csv").metadata["ended"])
"""
# The researcher comes last: the study installs an extra.
DOORS = {
    "readme": Door(("README.md",), README_RUN),
    "loop": Door(("docs/tutorials/the_basic_loop.md",), MOVED.format(file="run.h5")),
    "lecturer": Door(("docs/start/lecturer.md",), MOVED.format(file="still.h5") + PAGE_STOPS),
    "maker": Door(("docs/start/maker.md",), MOVED.format(file="moved.h5")),
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
    """A shell in a clone, with an environment in the place of ``.venv``."""

    def __init__(self, home: Path) -> None:
        """Start it in the clone below ``home``."""
        self.home, self.count = home, 0
        environment = (home / "musclewire/.venv").resolve()
        path = [folder for folder in os.environ["PATH"].split(os.pathsep) if folder != f"{environment}/bin"]
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
        typed = block.text if block.language == "python" else as_typed(block.text)
        file.write_text(typed, encoding="utf-8")
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


def follow(door: Door, home: Path, environment: Path) -> None:
    """Follow a door in a clone. Raises NotFollowedError with the block that failed."""
    type_in_a_clone([block for page in door.pages for block in blocks_of(page)], door.end, home, environment)


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


def cloned(home: Path) -> Path:
    """Return a clone of the last commit below a folder."""
    clone = home / "musclewire"
    subprocess.run(["git", "clone", "-q", "--no-hardlinks", str(CHECKOUT), str(clone)], check=True)
    return clone


def type_in_a_clone(blocks: Sequence[Block], end: str, home: Path, environment: Path) -> None:
    """Type blocks one after the other in a clone, then judge their end. Raises NotFollowedError as ``run``."""
    (cloned(home) / ".venv").symlink_to(environment)
    with ExitStack() as stack:
        first = Terminal(home)
        stack.callback(first.close)
        for block in blocks:
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
    terminal.begin(block)
    lines: list[str] = []
    try:
        for line in terminal.lines():
            lines.append(" ".join(line.split()))
    except NotFollowedError as error:
        refused = "; ".join(line for line in lines if line.startswith(("NO ", "musclewire: ")))
        raise NotFollowedError(f"{block.page}: {error}: {block.text.strip()}: {refused or lines[-1:]}") from error
    said = "\n".join(lines)
    for line in block.prints:
        if line not in said:
            raise NotFollowedError(f"{block.page} says that this is printed, and it is not: {line}")


def made_by_the_first_command(home: Path) -> Path:
    """Return the environment that README's first command makes in a clone."""
    clone = cloned(home)
    first = next(block for block in blocks_of("README.md") if block.language == "sh").text.splitlines()[0]
    print(first, flush=True)
    subprocess.run(["bash", "-c", first], cwd=clone, check=True)
    return clone / ".venv"


def size_mb(folder: Path) -> int:
    """Return how much a folder takes [MB]."""
    said = subprocess.run(["du", "-sm", str(folder)], capture_output=True, text=True, check=True).stdout
    return int(said.split()[0])


def main() -> int:
    """Follow the doors that are named, all without a name; return 1 if one cannot be followed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("doors", nargs="*", metavar="DOOR", help=f"of {', '.join(DOORS)}; all without a name")
    parser.add_argument("--environment", type=Path, help="a folder that README's first command made")
    given = parser.parse_args()
    if wrong := set(given.doors) - set(DOORS):
        parser.error(f"there is no door {', '.join(sorted(wrong))}; there are {', '.join(DOORS)}")
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        environment = given.environment or made_by_the_first_command(Path(folder))
        for name, door in DOORS.items():
            if given.doors and name not in given.doors:
                continue
            print(f"\n== {name}; the environment has {size_mb(environment)} MB", flush=True)
            began_s, home = time.monotonic(), Path(folder) / name
            home.mkdir()
            try:
                follow(door, home, environment.resolve())
            except NotFollowedError as error:
                failed.append(name)
                print(error)
            print(
                f"== {name}: {'failed' if name in failed else 'exit 0'} after {time.monotonic() - began_s:.0f} s",
                flush=True,
            )
    if failed:
        print(f"these doors do not lead to their ends: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
