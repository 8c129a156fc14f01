"""Follow the front doors of the documentation to the letter, in a fresh clone, and judge what is at their ends.

    python checks/follow_doors.py [DOOR ...]                 a clone and a virtual environment of its own
    python checks/follow_doors.py [DOOR ...] --installed     a clone, with the environment of this Python
    python checks/follow_doors.py [DOOR ...] --bare FOLDER   a clone in a bare Debian 12 (debootstrap; as root)

Every ``sh`` and ``python`` block of README and of a door's pages runs in the order in which it is read, in one shell,
and must succeed. A block that begins with "# second terminal" gets a shell of its own; the next one waits until it has
printed something, as a reader would. An indented line below a block is what it prints: it must occur in what it
printed. What is at the end is judged by the end's own lines, below. The clone is of the last commit. FOLDER gets a copy
of Debian 12 by `debootstrap --variant=minbase bookworm FOLDER` if it is empty; each door begins in a copy of that.
The README's second command, the tests, is left out; `.ci/run` runs it.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SECOND = "# second terminal"
SET_UP = ("python3 -m venv", "apt-get ")
PART = re.compile(r"^```(sh|python)\n(.*?)^```$|^((?: {4}[^\n]*\n)+)", re.M | re.S)
DONE = "==this block has ended=="
WAIT_FOR_SECOND_S = 120.0


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
away = 100 * np.abs(run["estimated_strain"] - run["target_strain"])[-400:]
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
    "lecturer": Door(("docs/start/lecturer.md",), MOVED.format(file="draught.h5")),
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
    for language, text, printed in PART.findall((ROOT / page).read_text("utf-8")):
        if language:
            found.append(Block(page, language, text))
        elif found:
            lines = tuple(" ".join(line.split()) for line in printed.splitlines() if line.strip())
            found[-1] = Block(page, found[-1].language, found[-1].text, found[-1].prints + lines)
    return found


class Terminal:
    """A shell in the clone, which runs one block after the other."""

    def __init__(self, shell: Sequence[str], home: Path, seen_as: str, environment: dict[str, str]) -> None:
        """Start it; ``seen_as`` is the path of ``home`` in this shell."""
        self.home, self.seen_as, self.count = home, seen_as, 0
        self.process = subprocess.Popen(
            [*shell, "bash"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=environment,
            start_new_session=True,
        )
        self.say(f"set -e; cd {seen_as}/musclewire")

    def say(self, line: str) -> None:
        """Type a line."""
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def begin(self, block: Block) -> None:
        """Type a block: it is read from a file, so that no program in it reads the blocks after it."""
        self.count += 1
        name = f"{id(self):x}_{self.count}.{'py' if block.language == 'python' else 'sh'}"
        (self.home / name).write_text(block.text, encoding="utf-8")
        run = ".venv/bin/python" if block.language == "python" else "."
        self.say(f"{run} {self.seen_as}/{name} </dev/null; echo '{DONE}'")

    def lines(self) -> Iterator[str]:
        """Return what it prints, line by line, until the block has ended."""
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
        self.process.wait()


def follow(door: Door, place: Place) -> None:
    """Follow a door in a place. Raises NotFollowedError with the block that failed."""
    blocks = [block for page in ("README.md", *door.pages) for block in blocks_of(page)]
    with ExitStack() as stack:
        first = place.terminal()
        stack.callback(first.close)
        for line in place.before:
            run(first, Block("README.md", "sh", line))
        for block in blocks:
            if place.installed and any(word in block.text for word in SET_UP):
                continue
            if block.text.startswith(SECOND):
                second = place.terminal()
                stack.callback(second.close)
                say(block)
                second.begin(block)
                second.first_line()
            else:
                run(first, block)
        run(first, Block("the end", "python", door.end))


def say(block: Block) -> None:
    """Print a block as a reader sees it."""
    print(f"-- {block.page}")
    print("".join(f"  $ {line}\n" for line in block.text.strip().splitlines()), end="", flush=True)


def run(terminal: Terminal, block: Block) -> None:
    """Run a block in a terminal and hold what it printed to what the page says it prints."""
    text = "".join(line + "\n" for line in block.text.splitlines() if "-m pytest" not in line)
    block = Block(block.page, block.language, text, block.prints)
    say(block)
    terminal.begin(block)
    began = time.monotonic()
    try:
        said = "\n".join(" ".join(line.split()) for line in terminal.lines())
    except NotFollowedError as error:
        raise NotFollowedError(f"{block.page}: {error}: {block.text.strip()}") from error
    print(f"  ({time.monotonic() - began:.0f} s)")
    for line in block.prints:
        if line not in said:
            raise NotFollowedError(f"{block.page} says that this is printed, and it is not: {line}")


class Place:
    """A fresh clone in a folder of its own, and the way to a shell in it."""

    installed = False
    before: tuple[str, ...] = ()

    def __init__(self, home: Path) -> None:
        """Clone the last commit into ``home``."""
        self.home = home
        subprocess.run(["git", "clone", "-q", "--no-hardlinks", str(ROOT), str(home / "musclewire")], check=True)

    def terminal(self) -> Terminal:
        """Return a new shell in the clone, without anything of this program's own environment."""
        kept = {name: value for name, value in os.environ.items() if name not in {"PYTHONPATH", "VIRTUAL_ENV"}}
        return Terminal((), self.home, str(self.home), {**kept, "COLUMNS": "120"})


class Installed(Place):
    """A clone with the environment of this Python in the place of `.venv`: nothing is installed."""

    installed = True

    def __init__(self, home: Path) -> None:
        """Clone, and link the environment. Raises NotFollowedError where this Python has none."""
        super().__init__(home)
        if sys.prefix == sys.base_prefix:
            raise NotFollowedError("--installed needs a Python of a virtual environment")
        (home / "musclewire/.venv").symlink_to(sys.prefix)

    def terminal(self) -> Terminal:
        """Return a shell that finds the package where this Python finds it, once the page has activated it."""
        path = [folder for folder in os.environ["PATH"].split(os.pathsep) if folder != f"{sys.prefix}/bin"]
        return Terminal((), self.home, str(self.home), {**os.environ, "PATH": os.pathsep.join(path), "COLUMNS": "120"})


# How this machine reaches Debian and PyPI: copied where it is there, and no part of what a reader does. Debian writes
# its own list of certificates when a package brings them, so this machine's has a name of its own.
ADDRESSES = ("/etc/resolv.conf", "/etc/hosts", "/etc/pip.conf", "/root/.config/pip")
CERTIFICATES, THEIR_COPY = Path("/etc/ssl/certs/ca-certificates.crt"), "/opt/certificates.crt"
PASSED_ON = re.compile(r"PIP_(?!FIND_LINKS).*|https?_proxy|no_proxy", re.I)
MOUNTS = "mount -t proc proc {0}/proc && mount -t tmpfs tmpfs {0}/dev/shm && exec chroot {0} env -i "


class Bare(Place):
    """A clone in a copy of a Debian 12 in which nothing is installed."""

    def __init__(self, debian: Path, root: Path) -> None:
        """Copy the Debian, made by debootstrap if need be, and clone into its home of root."""
        if not (debian / "usr").exists():
            subprocess.run(["debootstrap", "--variant=minbase", "bookworm", str(debian)], check=True)
        subprocess.run(["cp", "-a", f"{debian}/.", str(root)], check=True)
        for name in ADDRESSES:
            if Path(name).is_dir():
                shutil.copytree(name, root / name[1:], dirs_exist_ok=True)
            elif Path(name).exists():
                shutil.copy(name, root / name[1:])
        if CERTIFICATES.exists():
            shutil.copy(CERTIFICATES, root / THEIR_COPY[1:])
        super().__init__(root / "root")
        self.root = root
        readme = (ROOT / "README.md").read_text("utf-8")
        told = re.search(r"`(apt-get install [^`]*python3-venv)`", readme)
        if told is None:
            raise NotFollowedError("README does not say what a bare Debian needs")
        self.before = ("apt-get update -q", told[1])

    def terminal(self) -> Terminal:
        """Return a shell in the Debian, with mounts that end with it, and a bare environment."""
        passed = {name: value for name, value in os.environ.items() if PASSED_ON.fullmatch(name)}
        bare = {
            "HOME": "/root",
            "PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
            "COLUMNS": "120",
        }
        if CERTIFICATES.exists():
            bare["PIP_CERT"] = THEIR_COPY
        given = " ".join(f"{name}='{value}'" for name, value in (passed | bare).items())
        command = MOUNTS.format(self.root) + given + " DEBIAN_FRONTEND=noninteractive LANG=C.UTF-8 bash"
        return Terminal(("unshare", "--mount", "sh", "-c", command), self.root / "root", "/root", dict(os.environ))


def place_of(given: argparse.Namespace, folder: Path) -> Place:
    """Return the place that was asked for."""
    if given.bare is not None:
        return Bare(given.bare, folder)
    return Installed(folder) if given.installed else Place(folder)


def main(words: Sequence[str] | None = None) -> int:
    """Follow the doors that are named, or all; exit code 1 if one does not lead to its end."""
    parser = argparse.ArgumentParser(description="Follow the front doors of the documentation to the letter.")
    parser.add_argument("doors", nargs="*", metavar="DOOR", help=f"one or more of {', '.join(DOORS)}; all without any")
    parser.add_argument("--installed", action="store_true", help="with the environment of this Python")
    parser.add_argument(
        "--bare", type=Path, default=None, metavar="FOLDER", help="in a bare Debian 12 from this folder"
    )
    given = parser.parse_args(words)
    if unknown := set(given.doors) - set(DOORS):
        parser.error(f"there is no door called {', '.join(sorted(unknown))}: there are {', '.join(DOORS)}")
    results: dict[str, str] = {}
    for name in given.doors or DOORS:
        print(f"\n== {name}", flush=True)
        began = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="musclewire-door-", ignore_cleanup_errors=True) as folder:
            try:
                follow(DOORS[name], place_of(given, Path(folder)))
                results[name] = "followed to its end"
            except NotFollowedError as error:
                results[name] = f"NOT FOLLOWED: {error}"
        results[name] += f" ({time.monotonic() - began:.0f} s)"
    print("\n" + "\n".join(f"{name:12s}{result}" for name, result in results.items()))
    return int(any("NOT FOLLOWED" in result for result in results.values()))


if __name__ == "__main__":
    sys.exit(main())
