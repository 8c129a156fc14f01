"""Find names that do not tell apart: a class name with several meanings, a function or a parameter named by a particle.

    python checks/ambiguous_names.py [--core]

Each finding is a line: kind, name, places. A class name is ambiguous if it is defined in more than one file; the name
of a function, method or parameter, if it is one of the particles below and nothing else. ``--core`` leaves out the
folder ``extras``. ``ambiguous_names.toml`` lists the names that may stay, with reasons. Ends with exit code 1 if there
is a finding outside of that list, or if a name of the list is no longer found.
"""

from __future__ import annotations

import argparse
import ast
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1] / "src" / "musclewire"
ALLOWED = Path(__file__).with_suffix(".toml")
EXTRAS = "extras"
# Words that say nothing without the sentence around them.
FUNCTION_PARTICLES = frozenset({"at", "by", "from_", "in_", "now", "of", "on", "take", "taken", "then", "to", "within"})
PARAMETER_PARTICLES = frozenset({"by", "now", "of"})
KINDS = ("class", "function", "parameter")


class Finding(NamedTuple):
    """An ambiguous name: its kind, the name as the list spells it, and where it is defined."""

    kind: str
    name: str
    places: tuple[str, ...]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what is ambiguous and not allowed, and what is allowed for nothing."""
    parser = argparse.ArgumentParser(description="Find class, function and parameter names that do not tell apart.")
    parser.add_argument("--core", action="store_true", help="leave out the folder 'extras'")
    only_core = parser.parse_args(arguments).core
    allowed = tomllib.loads(ALLOWED.read_text(encoding="utf-8"))
    sources = {path.relative_to(ROOT).as_posix(): path for path in sorted(ROOT.rglob("*.py"))}
    modules = {
        name: ast.parse(path.read_text(encoding="utf-8"))
        for name, path in sources.items()
        if not (only_core and name.split("/")[0] == EXTRAS)
    }
    found = findings_in(modules)
    excess = [one for one in found if one.name not in allowed[one.kind]]
    for one in excess:
        print(f"{one.kind} {one.name}: {', '.join(one.places)}")
    known = {(one.kind, one.name) for one in found}
    idle = [(kind, name) for kind in KINDS for name in allowed[kind] if (kind, name) not in known and not only_core]
    for kind, name in idle:
        print(f"{ALLOWED.name}: {kind} {name} is not ambiguous any more: remove it")
    counts = ", ".join(f"{sum(one.kind == kind for one in found)} of kind {kind}" for kind in KINDS)
    print(f"{len(modules)} files: {counts}; {len(found) - len(excess)} of them allowed")
    return 1 if excess or idle else 0


def findings_in(modules: dict[str, ast.Module]) -> list[Finding]:
    """Return what is ambiguous in modules by their path: class names first."""
    classes: dict[str, list[str]] = defaultdict(list)
    particles: list[Finding] = []
    for path, module in modules.items():
        for name in sorted({node.name for node in ast.walk(module) if isinstance(node, ast.ClassDef)}):
            classes[name].append(path)
        particles += particles_in(module, path, "")
    several = [Finding("class", name, tuple(paths)) for name, paths in sorted(classes.items()) if len(paths) > 1]
    return several + particles


def particles_in(scope: ast.AST, path: str, owner: str) -> Iterator[Finding]:
    """Yield functions and parameters of a scope, and of the scopes in it, whose whole name is a particle."""
    for node in ast.iter_child_nodes(scope):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield from particles_in(node, path, owner)
            continue
        name = f"{owner}{node.name}"
        if not isinstance(node, ast.ClassDef):
            if node.name in FUNCTION_PARTICLES:
                yield Finding("function", f"{path}:{name}", (f"{path}:{node.lineno}",))
            for one in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
                if one.arg in PARAMETER_PARTICLES:
                    yield Finding("parameter", f"{path}:{name}({one.arg})", (f"{path}:{one.lineno}",))
        yield from particles_in(node, path, f"{name}.")


if __name__ == "__main__":
    sys.exit(main())
