"""List the files and the containers that one key of a rig file passes through, from its line to the wire's step.

    NUMBA_DISABLE_JIT=1 python checks/files_of_a_rig_key.py [KEY]

KEY is ``pretension`` unless another is given. A rig file that says it is opened with compilation off, so that every
function is seen. Its number is one that occurs nowhere else.

Counted is each file of musclewire in which a function is called with the number or returns it: bare, as the file's
text, or in data at any depth (a mapping, a sequence, a model of pydantic, a dataclass, a named tuple, a row of the
wire). Also counted is the file of each class in which the number stands. A container is what the number stands in
directly, with its name there: ``Bench`` holds a ``Parameter``, and that holds the number. What has a state of its own
(a rig, a device) is no container, but the files of its functions that take the number count.

The way ends at ``StepConstants``, the row that a step reads: what takes the number only there is the step. The mapping
that the TOML parser returns is the file itself and no container.
"""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

os.environ.setdefault("NUMBA_DISABLE_JIT", "1")  # before anything imports Numba

import numpy as np
from pydantic import BaseModel

import musclewire as mw
from musclewire.wire import Row, StepConstants, WireConstants

PACKAGE = Path(mw.__file__).parent
# Numbers that each key allows and that stand nowhere else.
TEXTS = {
    "wire_length": ("0.1413171 m", 0.1413171),
    "shunt": ("0.5137193 ohm", 0.5137193),
    "pretension": ("1.7319371 N", 1.7319371),
    "ambient_temperature": ("294.7319371 K", 294.7319371),
}
END = (StepConstants.__name__,)

Container = tuple[str, str]


class Watch:
    """Notes files and containers of one number while a rig is opened."""

    def __init__(self, text: str, number: float) -> None:
        """Start with no file; ``text`` is the number as the rig file says it."""
        self.text, self.number = text, number
        self.files: set[Path] = set()
        self.containers: list[Container] = []
        self._step: FrameType | None = None
        self._ended = False

    def note(self, frame: FrameType, event: str, argument: Any) -> None:
        """Note the file of a function that is called with the number, or that returns it."""
        if frame is self._step and event == "return":
            # After the first steps the force of the wire at rest is the same number, and not what the file said.
            self._step, self._ended = None, frame.f_code.co_name == "advance_rows"
            return
        path = Path(frame.f_code.co_filename)
        expression = frame.f_code.co_name.startswith("<")  # a comprehension, which is no function from Python 3.12 on
        if self._ended or self._step is not None or event not in ("call", "return"):
            return
        if expression or not path.is_relative_to(PACKAGE):
            return
        given = arguments_of(frame) if event == "call" else [argument]
        found = [place for value in given for place in self.places(value)]
        if found and all(place[:1] == END for place in found):
            self._step = frame if event == "call" else None
        elif found:
            self.files.add(path)
            self.containers += [place for place in found if place != ("", "") and place not in self.containers]

    def is_it(self, value: Any) -> bool:
        """Return whether a value is the number itself, or the file's text of it."""
        return isinstance(value, str | float) and value in (self.text, self.number)

    def places(self, value: Any, within: Container = ("", "")) -> Iterator[Container]:
        """Yield where the number stands in a value: the container and its name there, both empty for itself."""
        if self.is_it(value):
            yield within
        else:
            for name, item in items_of(value):
                yield from self.places(item, (self.container_of(value, name, item), name))

    def container_of(self, value: Any, name: str, item: Any) -> str:
        """Return the name of a container's class; note the file in which the class that declares a name is defined."""
        if isinstance(value, np.ndarray):
            wire = set(value.dtype.names or ()) == {field.name for field in WireConstants.fields}
            return WireConstants.__name__ if wire else StepConstants.__name__
        kind = type(value)
        own = next((base for base in kind.__mro__ if name in vars(base).get("__annotations__", {})), kind)
        if own.__module__.startswith("musclewire") and own is not StepConstants and self.is_it(item):
            self.files.add(Path(inspect.getsourcefile(own) or ""))
        return kind.__name__


def arguments_of(frame: FrameType) -> list[Any]:
    """Return what a function is called with; what it takes by any name or position is bare as well."""
    code = frame.f_code
    plain = code.co_argcount + code.co_kwonlyargcount
    several = bool(code.co_flags & inspect.CO_VARARGS) + bool(code.co_flags & inspect.CO_VARKEYWORDS)
    given = [frame.f_locals[name] for name in code.co_varnames[:plain] if name in frame.f_locals]
    for name in code.co_varnames[plain : plain + several]:
        more = frame.f_locals[name]
        given += more.values() if isinstance(more, Mapping) else more
    return given


def items_of(value: Any) -> list[tuple[str, Any]]:
    """Return the parts of data by their names; nothing for anything else."""
    if isinstance(value, Mapping):
        return [(str(name), item) for name, item in value.items()]
    if isinstance(value, BaseModel):
        return list(vars(value).items())
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return list(value._asdict().items())
    if isinstance(value, list | tuple):
        return [("", item) for item in value]
    if isinstance(value, Row) and hasattr(value, "row"):
        return [(field.name, getattr(value, field.name)) for field in value.fields if field.length is None]
    if isinstance(value, np.ndarray) and value.dtype.names and value.size:
        return [(name, value[name].flat[0].item()) for name in value.dtype.names if value[name].shape == value.shape]
    if is_dataclass(value) and not isinstance(value, type):
        return [(field.name, getattr(value, field.name, None)) for field in fields(value)]
    return []


def watched(key: str) -> Watch:
    """Return what was noted while a simulated rig whose file gives a key was opened."""
    text, number = TEXTS[key]
    watch = Watch(text, number)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "rig.toml"
        file.write_text(f'{key} = "{text}"\n', "utf-8")
        with mw.open_rig("simulated"):  # so that what is loaded once is loaded
            pass
        sys.setprofile(watch.note)
        try:
            rig = mw.open_rig(file)
        finally:
            sys.setprofile(None)
        rig.close()
    return watch


def main() -> None:
    """Print the files, then the containers, then how many there are of both."""
    key = sys.argv[1] if len(sys.argv) > 1 else "pretension"
    watch = watched(key)
    passed = sorted(path.relative_to(PACKAGE).as_posix() for path in watch.files)
    containers = [place for place in watch.containers if place != ("dict", key) and place[:1] != END]
    for name in passed:
        print(f"file {name}")
    for container, name in containers:
        print(f"container {container}.{name}")
    print(f"{len(passed)} files, {len(containers)} containers")


if __name__ == "__main__":
    main()
