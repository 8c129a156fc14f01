"""List the files of musclewire that one sample of the default simulated control passes through.

    NUMBA_DISABLE_JIT=1 python checks/files_in_one_sample.py

Compilation is off, so that every function is seen. Counted are the files whose functions run between two samples, and
the files that define the classes of what is passed to these functions. One line each, then their number. A test holds
the list to ARCHITECTURE.md. Not counted is ``compiled.py``: what of it runs here is what Numba itself does while
compilation is on.
"""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

os.environ.setdefault("NUMBA_DISABLE_JIT", "1")  # before anything imports Numba

import musclewire as mw

PACKAGE = Path(mw.__file__).parent
# From a wire that starts cold to one that follows its target: what any watched sample passes through is listed.
SAMPLES, WATCHED_ONE_IN = 120, 10


class SampleWatched(Exception):  # noqa: N818  # no error: it ends the run after the watched samples
    """Ends the run."""


class Watch:
    """Notes files from one callback of the loop to the next."""

    def __init__(self) -> None:
        """Start with no file."""
        self.files: set[Path] = set()
        self.samples = 0

    def on_sample(self, row: Mapping[str, float]) -> None:
        """Watch the way to the next sample now and then; end the run after enough samples."""
        del row
        self.samples += 1
        sys.setprofile(self.note if self.samples % WATCHED_ONE_IN == 0 else None)
        if self.samples > SAMPLES:
            raise SampleWatched

    def note(self, frame: FrameType, event: str, argument: Any) -> None:
        """Note the file of a function that is called, and those that define the classes of its arguments."""
        del argument
        if event != "call" or frame.f_code is self.on_sample.__func__.__code__:
            return
        path = Path(frame.f_code.co_filename)
        if not path.is_relative_to(PACKAGE) or path == PACKAGE / "compiled.py":
            return
        self.files.add(path)
        for name in frame.f_code.co_varnames[: frame.f_code.co_argcount + frame.f_code.co_kwonlyargcount]:
            self.note_class(type(frame.f_locals.get(name)))

    def note_class(self, kind: type) -> None:
        """Note the file that defines a class, if it is one of ours."""
        if kind.__module__.startswith("musclewire"):
            self.files.add(Path(inspect.getsourcefile(kind) or ""))


def model_of_the_default_wire() -> mw.SensingModel:
    """Return the model of the simulated rig's wire, found by other processes, in which compilation is on."""
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"}
    with TemporaryDirectory() as folder:
        for arguments in ("characterize simulated -o loop.h5", "fit loop.h5 -o model.json"):
            command = [sys.executable, "-m", "musclewire", *arguments.split()]
            subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True)
        return mw.load_model(Path(folder) / "model.json")


def watched_files() -> list[str]:
    """Return the files of one sample, relative to the package, in order."""
    watch = Watch()
    model = model_of_the_default_wire()
    with mw.open_rig("simulated") as rig, suppress(SampleWatched):
        mw.control(rig, model, mw.staircase(), on_sample=watch.on_sample)
    return sorted(path.relative_to(PACKAGE).as_posix() for path in watch.files)


def main() -> None:
    """Print the files with their lengths, then how many there are."""
    passed = watched_files()
    for name in passed:
        print(f"{len((PACKAGE / name).read_text(encoding='utf-8').splitlines()):5d} {name}")
    print(f"{len(passed)} files")


if __name__ == "__main__":
    main()
