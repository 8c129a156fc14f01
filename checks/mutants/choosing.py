"""Which tests judge a mutant, and whether with compilation on or off.

With compilation on the tests run a hundred times as fast, but a changed function that is compiled, and a constant that
compiled code has copied, need it off: compiling the kernels takes a minute.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from checks.mutants.collecting import IMPORT
from checks.mutants.operators import Mutant

__all__ = ["Chosen", "Measured", "Sources"]

COMPILED = frozenset({"compiled", "compiled_inline"})
# Files of tests that are imported for the first look at a mutant; the others follow if it survives that.
FIRST_FILES = 8


class Function(NamedTuple):
    """A function that is in no other one: its file, its lines, whether it is compiled, and the names it mentions."""

    path: str
    first: int
    last: int
    compiled: bool
    names: frozenset[str]


class Sources:
    """The files of the rooms: their functions, and which files hold what compiled code has copied."""

    def __init__(self, folder: Path, package: Path) -> None:
        """Read all files of a package; ``folder`` is where paths begin."""
        self.functions: list[Function] = []
        self._imports: dict[str, set[str]] = {}
        for path in sorted((folder / package).rglob("*.py")):
            name, tree = str(path.relative_to(folder)), ast.parse(path.read_text(encoding="utf-8"))
            self._read(name, tree)
            self._imports[name] = set(imported_files(tree, folder))

    def _read(self, path: str, tree: ast.Module) -> None:
        """Note the functions of a file."""
        waiting: list[ast.AST] = [tree]
        while waiting:
            for node in ast.iter_child_nodes(waiting.pop()):
                if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                    names = {getattr(part, "id", None) or getattr(part, "attr", None) for part in ast.walk(node)}
                    marks = {getattr(mark, "id", "") for mark in node.decorator_list}
                    known = frozenset(name for name in names if name)
                    first, last = node.body[0].lineno, node.end_lineno or node.lineno
                    self.functions.append(Function(path, first, last, bool(marks & COMPILED), known))
                else:
                    waiting.append(node)

    @cached_property
    def copied(self) -> frozenset[str]:
        """Files whose module-level values compiled code may copy: those with compiled functions, and their imports."""
        waiting = [one.path for one in self.functions if one.compiled]
        found: set[str] = set()
        while waiting:
            path = waiting.pop()
            if path not in found:
                found.add(path)
                waiting += self._imports.get(path, ())
        return frozenset(found)

    def function_of(self, mutant: Mutant) -> Function | None:
        """Return the outermost function that a mutant is in; None at import."""
        if mutant.runs_at_import:
            return None
        around = (one for one in self.functions if one.path == mutant.path and one.first <= mutant.line <= one.last)
        return next(around, None)

    def mode_of(self, mutant: Mutant) -> str:
        """Return "plain" for a mutant that needs compilation off, "compiled" for any other."""
        function = self.function_of(mutant)
        if function is None:
            return "plain" if mutant.path in self.copied else "compiled"
        return "plain" if function.compiled else "compiled"


def imported_files(tree: ast.Module, folder: Path) -> Iterable[str]:
    """Yield the files of the package that a file imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("musclewire"):
            for name in (node.module, *(f"{node.module}.{alias.name}" for alias in node.names)):
                path = Path("src", *name.split("."))
                for file in (path.with_suffix(".py"), path / "__init__.py"):
                    if (folder / file).is_file():
                        yield str(file)


class Chosen(NamedTuple):
    """Tests that judge a mutant: first those of few files, then the others; and the processor time of all [s]."""

    stages: list[list[str]]
    cpu_s: float


class Measured:
    """What the tests run, measured once with compilation on or off."""

    def __init__(self, parts: Sequence[Mapping[str, Any]], sources: Sources) -> None:
        """Put together what several runs have found."""
        self._sources = sources
        self.left_out = {name: why for part in parts for name, why in part["left_out"].items()}
        every = {name: spent for part in parts for name, spent in part["cpu_s"].items()}
        self.cpu_s = {name: spent for name, spent in every.items() if name not in self.left_out}
        self._in_file: dict[str, list[str]] = defaultdict(list)
        for name in self.cpu_s:
            self._in_file[name.split("::")[0]].append(name)
        self._lines: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
        for part in parts:
            for path, lines in part["lines"].items():
                for line, contexts in lines.items():
                    self._lines[path][int(line)].update(contexts)

    def _tests_of_lines(self, path: str, first: int, last: int) -> set[str]:
        """Return the tests that run any of some lines."""
        found: set[str] = set()
        for context in set().union(*(self._lines[path].get(line, ()) for line in range(first, last + 1))):
            found.update(self._in_file[context.removeprefix(IMPORT)] if context.startswith(IMPORT) else (context,))
        return found & self.cpu_s.keys()

    def tests_of(self, mutant: Mutant) -> set[str]:
        """Return the tests that run a mutant's statement; at import, a function that mentions its names.

        What runs only in processes that a test starts is not measured: then tests in files that name its file count.
        """
        stem = Path(mutant.path).stem
        named = {name for file, names in self._in_file.items() if stem in Path(file).stem for name in names}
        if not mutant.runs_at_import:
            return self._tests_of_lines(mutant.path, *mutant.statement) or named
        names = names_of(mutant)
        users = [one for one in self._sources.functions if one.names & names]
        near = [one for one in self._sources.functions if one.path == mutant.path]
        for functions in (users, near):
            found = set().union(*(self._tests_of_lines(one.path, one.first, one.last) for one in functions))
            if found:
                return found
        return named

    def chosen(self, mutant: Mutant, budget_s: float) -> Chosen:
        """Return the tests of a mutant, the quickest first, as many as a budget of processor time allows."""
        tests, spent_s = [], 0.0
        for name in sorted(self.tests_of(mutant), key=lambda name: (self.cpu_s[name], name)):
            spent_s += self.cpu_s[name]
            if tests and spent_s > budget_s:
                spent_s -= self.cpu_s[name]
                break
            tests.append(name)
        room = mutant.path.split("/")[2]
        by_file: dict[str, int] = defaultdict(int)
        for name in tests:
            by_file[name.split("::")[0]] += 1
        stem = Path(mutant.path).stem
        ranked = sorted(by_file, key=lambda file: (stem not in file, f"/{room}/" not in file, -by_file[file], file))
        first = [name for name in tests if name.split("::")[0] in ranked[:FIRST_FILES]]
        rest = [name for name in tests if name.split("::")[0] not in ranked[:FIRST_FILES]]
        return Chosen([stage for stage in (first, rest) if stage], spent_s)


def names_of(mutant: Mutant) -> set[str]:
    """Return the names that a statement at import defines, or the classes it is in."""
    head = mutant.text.split("=")[0].split(":")[0].strip()
    return {part.strip() for part in head.split(",")} | set(mutant.within[-1:])
