"""Count the names that are promised to users and those that cross a room's wall, and find imports behind a wall.

    python checks/walls.py [--list]

A room is a folder of ``src/musclewire`` or of its ``extras``, or a file beside them. Its list is the stub
``__init__.pyi``; modules behind it begin with an underscore. Ends with exit code 1 for

- an import behind another room's list, wherever in the checkout it stands; tests below ``tests/unit/ROOM`` and
  ``tests/extras/NAME`` may import what is behind their own;
- a name on a list that nobody uses, and one that is used and not on it;
- a name that a page, an example or a notebook takes from anywhere but ``musclewire`` and ``musclewire.compiled``;
- an import that leads what runs on a real wire to the simulated one, name by name and through the lists.

With ``--list`` it also prints which names cross, by room.
"""

from __future__ import annotations

import argparse
import ast
import json
import re
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "src"
MAX_PROMISED, MAX_CROSSING = 150, 500
# What those who use the package may import from.
FOR_USERS = ("musclewire", "musclewire.compiled")
# Python that is not of the package and is held to its lists.
OUTSIDE = ("tests", "benchmarks", "checks", "docs", "emulation", "firmware", "hardware", "packages", "studies",
           "examples")  # fmt: skip
# Pages and programs that users read and copy from; decisions also say what is no more.
USERS_PAGES = ("README.md", "docs/start", "docs/tutorials", "docs/how-to", "docs/explanation", "docs/reference",
               "docs/notebooks", "docs/lesson", "examples")  # fmt: skip
HISTORY = "docs/explanation/decisions"
# What runs on a real wire, and what it must not reach: the simulated rig, and a wire through time.
ON_A_REAL_WIRE = (
    "musclewire.sensing", "musclewire.controllers", "musclewire.rigs._guarded", "musclewire.rigs._device",
    "musclewire.rigs._kinds", "musclewire.rigs._mounted_wire", "musclewire.rigs._wire_limits",
    "musclewire.rigs._replay",
    "musclewire.extras.board._nidaq", "musclewire.extras.board._serial",
    "musclewire.extras.grip._contact_detection", "musclewire.extras.grip._grip_force",
)  # fmt: skip
SIMULATED = (
    "musclewire.rigs._simulated", "musclewire.wire._batch", "musclewire.wire._lanes", "musclewire.wire._lane_views",
    "musclewire.wire._paths", "musclewire.wire._wires",
    "musclewire.extras.grip._coupling", "musclewire.extras.grip._pairs", "musclewire.extras.grip._two_wires",
)  # fmt: skip


class Import(NamedTuple):
    """A name that a file imports: from which module, and whether for annotations alone; the name is "" for a module."""

    module: str
    name: str
    line: int
    annotation: bool


@dataclass(frozen=True)
class House:
    """The modules of the package by name, and what each room lists: name to the module that defines it."""

    modules: Mapping[str, str]
    lists: Mapping[str, Mapping[str, str]]

    def room_of(self, module: str) -> str:
        """Return the room that a module belongs to."""
        parts = module.split(".")
        return ".".join(parts[: 3 if parts[1:2] == ["extras"] else 2])

    def behind(self, module: str) -> bool:
        """Return whether a module stands behind a room's list."""
        return any(part.startswith("_") and not part.startswith("__") for part in module.split("."))

    def defining(self, module: str, name: str) -> str:
        """Return the module that a name comes from: through a room's list the one that defines it."""
        return self.lists.get(module, {}).get(name, module)


def module_name(path: Path, sources: Path) -> str:
    """Return the name of a module by its file."""
    return ".".join(path.relative_to(sources).with_suffix("").parts).removesuffix(".__init__")


def house_in(sources: Path) -> House:
    """Return the modules and lists of the package in a folder."""
    modules = {module_name(path, sources): path.read_text("utf-8") for path in sorted(sources.rglob("*.py"))}
    lists = {
        module_name(path, sources): listed(module_name(path, sources), path.read_text("utf-8"))
        for path in sorted(sources.rglob("*.pyi"))
    }
    return House(modules, lists)


def listed(room: str, stub: str) -> dict[str, str]:
    """Return the names on a room's list with the modules that define them; of parts' names the module is ""."""
    found = {}
    for node in ast.parse(stub).body:
        if isinstance(node, ast.ImportFrom):
            found.update({alias.name: f"{room}.{node.module}" for alias in node.names})
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.target.id[0] != "_":
            found[node.target.id] = ""
    return found


def imports_of(text: str, modules: Iterable[str] = ()) -> Iterator[Import]:
    """Yield what a file imports of the package; ``modules`` are those that there are."""
    known = frozenset(modules)
    for module, name, line, annotation in imports_from(text):
        inner = f"{module}.{name}"
        at = (inner, "") if inner in known else (module, name)
        yield Import(*at, line, annotation)


@cache  # the same file is asked about from many sides
def imports_from(text: str) -> list[Import]:
    """Return what a file imports of the package, as it is written: a name may be a module's."""
    tree, found = ast.parse(text), []
    for_annotations = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        annotation = id(node) in for_annotations
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names if alias.name.split(".")[0] == "musclewire"]
            found += [Import(name, "", node.lineno, annotation) for name in names]
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "musclewire":
            found += [Import(str(node.module), alias.name, node.lineno, annotation) for alias in node.names]
    return found


def own_room(path: Path) -> str:
    """Return the room whose private modules a test may import, by its place; "" for any other file."""
    match path.parts[:3]:
        case ("tests", "unit", room):
            return f"musclewire.{room}"
        case ("tests", "extras", part):
            return f"musclewire.extras.{part}"
    return ""


def behind_walls(house: House, outside: Mapping[Path, str]) -> list[str]:
    """Return the imports that go behind another room's list."""
    found = []
    for module, text in house.modules.items():
        for one in imports_of(text, house.modules):
            if house.behind(one.module) and house.room_of(one.module) != house.room_of(module):
                found.append(f"src: {module}:{one.line} imports {one.module}: take it from {house.room_of(one.module)}")
    for path, text in outside.items():
        for one in imports_of(text, house.modules):
            if house.behind(one.module) and house.room_of(one.module) != own_room(path):
                found.append(f"{path}:{one.line} imports {one.module}: take it from {house.room_of(one.module)}")
    return found


class Crossing(NamedTuple):
    """Names of rooms, "room name", by who takes them from another room: the package, or only what stands outside it.

    Those that only extras take are counted in ``at_run_time`` or ``annotations_only``, too.
    """

    at_run_time: frozenset[str]
    extras_only: frozenset[str]
    annotations_only: frozenset[str]
    outside_only: frozenset[str]
    tests_only: frozenset[str]


def crossing(house: House, outside: Mapping[Path, str]) -> Crossing:
    """Return the names that cross a wall."""
    run, annotated, tests, others, core = set(), set(), set(), set(), set()
    for module, text in house.modules.items():
        for one in imports_of(text, house.modules):
            if one.name and house.room_of(one.module) not in (house.room_of(module), "musclewire"):
                name = f"{house.room_of(one.module)} {one.name}"
                (annotated if one.annotation else run).add(name)
                core |= set() if module.startswith("musclewire.extras.") else {name}
    for path, text in outside.items():
        for one in imports_of(text, house.modules):
            if one.name and not house.behind(one.module) and house.room_of(one.module) != "musclewire":
                (tests if path.parts[0] == "tests" else others).add(f"{house.room_of(one.module)} {one.name}")
    inside = run | annotated
    return Crossing(
        frozenset(run),
        frozenset(inside - core),
        frozenset(annotated - run),
        frozenset(others - inside),
        frozenset(tests - inside - others),
    )


def wrong_lists(house: House, outside: Mapping[Path, str], offered: Iterable[str]) -> list[str]:
    """Return names that are used and not listed, and names that are listed and used by nobody."""
    used: dict[str, set[str]] = defaultdict(set)
    for text in (*house.modules.values(), *outside.values()):
        for one in imports_of(text, house.modules):
            used[one.module].add(one.name)
    for place in offered:
        room, _, name = place.partition(":")
        used[room].add(name)
    for name, place in house.lists["musclewire"].items():
        if place:
            used[house.room_of(place)].add(name)
    found = []
    for room, names in house.lists.items():
        idle = set() if room == "musclewire" else names.keys() - used[room]
        found += [f"{room} lists {name}, which nobody uses: take it off" for name in sorted(idle)]
        folder = SOURCES.joinpath(*room.split("."))
        wanted = {name for name in used[room] - names.keys() if name and not name.startswith("__")}
        missing = sorted(name for name in wanted if not (folder / name).is_dir())
        found += [f"{name} is taken from {room}, which does not list it" for name in missing]
    return found


def reaches(house: House, starts: Iterable[str], ends: tuple[str, ...]) -> list[str]:
    """Return ways of imports from modules to others; a room's list leads only to where the imported name is defined."""
    graph = {
        module: {house.defining(one.module, one.name) for one in imports_of(text, house.modules)}
        for module, text in house.modules.items()
    }
    found = []
    for start in (module for module in graph if module.startswith(tuple(starts))):
        ways, queue = {start: (start,)}, [start]
        while queue:
            here = queue.pop()
            for further in sorted(graph.get(here, ())):
                if further not in ways:
                    ways[further] = (*ways[here], further)
                    queue.append(further)
        found += [" -> ".join(way) for module, way in ways.items() if module.startswith(ends)]
    return found


# A statement of Python on a page: after a prompt, in a quotation, or as it is.
STATEMENT = re.compile(r"^[ >]*(?:>>> )?(from (musclewire[\w.]*) import |import (musclewire[\w.]*))", re.M)


def strange_on_pages(pages: Mapping[Path, str]) -> list[str]:
    """Return what pages and examples import from anywhere but the promised modules."""
    found = []
    for path, text in pages.items():
        for match in STATEMENT.finditer(text):
            if (module := match[2] or match[3]) not in FOR_USERS:
                found.append(f"{path} imports from {module}: users are promised {' and '.join(FOR_USERS)} only")
    return found


def page_text(path: Path) -> str:
    """Return the text of a page or program; of a notebook its cells."""
    text = path.read_text("utf-8")
    if path.suffix != ".ipynb":
        return text
    return "\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"])


def texts_of(folders: Iterable[str], *suffixes: str) -> dict[Path, str]:
    """Return the texts of files in folders of the checkout by their paths in it."""
    files = [
        path for name in folders for path in ([ROOT / name] if (ROOT / name).is_file() else (ROOT / name).rglob("*"))
    ]
    chosen = [path for path in sorted(files) if path.suffix in suffixes and path.is_file()]
    return {path.relative_to(ROOT): page_text(path) for path in chosen}


def main() -> int:
    """Print both counts and what is wrong; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--list", action="store_true", help="also list the names that cross, by room")
    arguments = parser.parse_args()
    house, outside = house_in(SOURCES), texts_of(OUTSIDE, ".py")
    offered = re.findall(r'"(musclewire[\w.]*:\w+)"', "\n".join(house.modules.values()))
    pages = texts_of(USERS_PAGES, ".md", ".ipynb", ".py")
    found = crossing(house, outside)
    promised = len(house.lists["musclewire"])
    inside = len(found.at_run_time) + len(found.annotations_only)
    print(f"{promised} names are promised to users (at most {MAX_PROMISED})")
    print(
        f"{inside} names cross a wall in src (wanted: {MAX_CROSSING}), {len(found.extras_only)} of them by extras "
        f"alone and {len(found.annotations_only)} in annotations alone; {len(found.outside_only)} more only "
        f"benchmarks, checks and the like use, {len(found.tests_only)} only tests"
    )
    by_room = Counter(name.split()[0] for name in found.at_run_time | found.annotations_only)
    if arguments.list:
        for room, count in by_room.most_common():
            names = sorted(
                name.split()[1] for name in found.at_run_time | found.annotations_only if name.split()[0] == room
            )
            print(f"{count:4d} {room}: {', '.join(names)}")
    problems = behind_walls(house, outside) + wrong_lists(house, outside, offered)
    problems += strange_on_pages({path: text for path, text in pages.items() if HISTORY not in path.as_posix()})
    problems += reaches(house, ON_A_REAL_WIRE, SIMULATED)
    problems += [f"{promised} names are promised, over {MAX_PROMISED}"] if promised > MAX_PROMISED else []
    print(
        "\n".join(problems) or "no import goes behind a wall, and what runs on a real wire cannot see the simulated one"
    )
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
