"""Count what there is to hold in mind, and hold it to the record: no size in size.toml may rise.

    python checks/size.py [--json | --record]

Exit code 1 if one has risen: take away as much elsewhere, or, where that cannot be, raise the record by ``--record`` in
a commit of its own that says what it bought. One that has fallen passes; ``--record`` keeps it from rising again, in
the same commit. ``--json`` prints all sizes as one document.

The core is src/musclewire without its extras. A number is a literal: a constant at module level, a default of a field
or a parameter, one inside a function but 0, 1, 2, -1 and 1/2, or one in a TOML file of methods (all of the core's but
those of parameters and figures, which are facts with their sources). A branch is an if, a conditional expression,
a chain of and and or. Functions are counted as they are entered, kernels as Python; what ``control`` imports is counted
in a process of its own.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RECORD = Path(__file__).with_suffix(".toml")
PACKAGE = ROOT / "src" / "musclewire"
COMMAND_SURFACE = ROOT / "tests/house/command_surface.toml"
# Printed and not held: facts may be added without paying for them.
NOT_HELD = {"data_lines", "test_lines"}
Function = ast.FunctionDef | ast.AsyncFunctionDef


def tracked(*patterns: str) -> list[Path]:
    """Return the files of the checkout that match, those that are new among them."""
    said = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", *patterns],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    return [ROOT / line for line in said.splitlines() if (ROOT / line).is_file()]


def lines_in(paths: Iterable[Path]) -> int:
    """Return how many lines files have."""
    return sum(path.read_text("utf-8").count("\n") for path in paths)


def numbers_in(node: ast.AST) -> Iterator[float]:
    """Yield the literals below a node, each with its sign."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant):
        yield from (-number for number in numbers_in(node.operand))
    elif isinstance(node, ast.Constant):
        if isinstance(node.value, int | float) and not isinstance(node.value, bool):
            yield node.value
    else:
        for child in ast.iter_child_nodes(node):
            yield from numbers_in(child)


def defaults_of(function: Function) -> list[ast.AST]:
    """Return the defaults of a function's parameters."""
    return [node for node in (*function.args.defaults, *function.args.kw_defaults) if node is not None]


def numbers_of(tree: ast.Module) -> tuple[int, int, int]:
    """Return how many numbers stand at module level, as defaults, and in functions."""
    functions = [node for node in ast.walk(tree) if isinstance(node, Function)]
    # A function within another one is counted with it.
    inner = {below for one in functions for below in ast.walk(one) if below is not one and isinstance(below, Function)}
    bodies = chain.from_iterable(one.body for one in functions if one not in inner)
    fields = [
        member.value
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        for member in node.body
        if isinstance(member, ast.AnnAssign | ast.Assign) and member.value is not None
    ]
    level = [
        node.value for node in tree.body if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None
    ]
    defaults = chain(fields, *map(defaults_of, functions))
    in_functions = [number for body in bodies for number in numbers_in(body) if number not in (0, 1, 2, -1, 0.5)]
    return (
        sum(len(list(numbers_in(node))) for node in level),
        sum(len(list(numbers_in(node))) for node in defaults),
        len(in_functions),
    )


def numbers_in_table(value: Any) -> int:
    """Return how many numbers a TOML value holds."""
    if isinstance(value, dict):
        return sum(map(numbers_in_table, value.values()))
    if isinstance(value, list):
        return sum(map(numbers_in_table, value))
    return int(isinstance(value, int | float) and not isinstance(value, bool))


def imports_private(tree: ast.Module) -> bool:
    """Return whether a file imports a module whose name begins with an underscore."""
    imported = chain.from_iterable(
        [node.module or ""] if isinstance(node, ast.ImportFrom) else [alias.name for alias in node.names]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
    )
    return any(name.startswith("musclewire.") and "._" in name for name in imported)


def static_sizes() -> dict[str, int]:
    """Return the sizes that the files alone tell."""
    src, methods, facts = tracked("src/musclewire/*.py"), [], []
    core = [path for path in src if "extras" not in path.relative_to(PACKAGE).parts]
    for path in tracked("src/musclewire/*.toml", "src/musclewire/*.json", "src/musclewire/*.hex"):
        room, *_ = path.relative_to(PACKAGE).parts
        (methods if path.suffix == ".toml" and room not in ("extras", "parameters", "figures") else facts).append(path)
    trees = {path: ast.parse(path.read_text("utf-8")) for path in [*src, *tracked("tests/*.py")]}
    numbers = [sum(kind) for kind in zip(*(numbers_of(trees[path]) for path in core), strict=True)]
    in_methods = sum(numbers_in_table(tomllib.loads(path.read_text("utf-8"))) for path in methods)
    nodes = [node for path in core for node in ast.walk(trees[path])]
    tests = [path for path in trees if path not in set(src)]
    options = {
        name
        for command in tomllib.loads(COMMAND_SURFACE.read_text("utf-8"))["command"].values()
        for option in command["options"]
        for name in re.findall(r"--[a-z-]+", option.partition("=")[0])
    }
    return {
        "core_files": len(core),
        "core_lines": lines_in(core),
        "core_statements": sum(isinstance(node, ast.stmt) for node in nodes),
        "core_branches": sum(isinstance(node, ast.If | ast.IfExp | ast.BoolOp) for node in nodes),
        "core_numbers": sum(numbers) + in_methods,
        "src_files": len(src),
        "src_lines": lines_in(src),
        "src_statements": sum(isinstance(node, ast.stmt) for path in src for node in ast.walk(trees[path])),
        "c_lines": lines_in(tracked("src/*.c", "src/*.h", "firmware/*.c", "firmware/*.h", "firmware/*.ino")),
        "javascript_lines": lines_in(path for path in tracked("src/*.js") if "vendor" not in path.parts),
        "method_toml_lines": lines_in(methods),
        "data_lines": lines_in(facts),
        "options": len(options),
        "test_lines": lines_in(tests),
        "private_test_lines": lines_in(path for path in tests if imports_private(trees[path])),
        "words": sum(len(path.read_text("utf-8").split()) for path in tracked("*.md")),
    }


def names_over_walls() -> int:
    """Return how many names rooms take from each other, as checks/walls.py counts them."""
    sys.path.insert(0, str(ROOT))
    from checks.walls import OUTSIDE, SOURCES, crossing, house_in, texts_of

    found = crossing(house_in(SOURCES), texts_of(OUTSIDE, ".py"))
    return len(found.at_run_time) + len(found.annotations_only)


class Entered:
    """The functions of the package that are entered in a ``with`` block."""

    def __init__(self) -> None:
        """None yet."""
        self.functions: set[tuple[str, str]] = set()

    def called(self, frame: Any, event: str, _argument: Any) -> None:
        """Note a call; this is the profile function."""
        code = frame.f_code
        inside = code.co_filename.startswith(str(PACKAGE)) and not code.co_filename.endswith("compiled.py")
        if event == "call" and inside and not code.co_name.startswith("<"):
            self.functions.add((code.co_filename, code.co_qualname))

    def __enter__(self) -> Entered:
        """Begin to look."""
        sys.setprofile(self.called)
        return self

    def __exit__(self, *_problem: object) -> None:
        """Look no more."""
        sys.setprofile(None)


class EnoughError(Exception):
    """The samples that are looked at have passed."""


def journeys(folder: Path) -> dict[str, int]:
    """Return how many functions are entered by a fit, a recording's way and one sample; kernels are Python here."""
    import matplotlib as mpl

    import musclewire as mw

    mpl.use("Agg")
    for path in PACKAGE.rglob("*.py"):  # what a module does while it is imported is not on anybody's way
        if "extras" not in path.parts or "lab_files" in path.parts:
            import_module(".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts))
    loop, text = mw.read_recording(folder / "loop.h5"), folder / "bench.csv"
    columns = {"wire_voltage_v": "Vw:V", "shunt_voltage_v": "Vr:V", "displacement_m": "Disp:mm"}
    rows = zip(loop["time_s"], *(loop[name] for name in columns), strict=True)
    lines = [f"{t:.6g},{wire:.6g},{shunt:.6g},{1e3 * moved:.6g}\n" for t, wire, shunt, moved in rows]
    text.write_text("Time [s],Vw [V],Vr [V],Disp [mm]\n" + "".join(lines), encoding="utf-8")
    metadata = {key: loop.metadata[key] for key in ("shunt_resistance_ohm", "leg_length_m")}
    with Entered() as way:
        read = mw.read_recording(text, columns=columns, metadata=metadata)
        with Entered() as fit:
            model = mw.fit(read)
        sys.setprofile(way.called)
        mw.estimate(model, read).plot()
    sample, count = Entered(), 0

    def looked_at(_row: object) -> None:
        nonlocal count
        count += 1
        sys.setprofile(sample.called if count % 10 == 0 else None)
        if count > 60:
            raise EnoughError

    model = mw.fit(loop)
    try:
        with mw.open_rig("simulated") as rig:
            mw.control(rig, model, mw.staircase(), on_sample=looked_at)
    except EnoughError:
        sys.setprofile(None)
    return {
        "functions_by_fit": len(fit.functions),
        "functions_by_recording": len(way.functions | fit.functions),
        "functions_by_sample": len(sample.functions),
    }


def imports_of_control(folder: Path) -> dict[str, int]:
    """Return the files and lines of the core that a closed loop with a model from a file imports."""
    import musclewire as mw

    def enough(_row: object) -> None:
        raise EnoughError

    try:
        with mw.open_rig("simulated") as rig:
            mw.control(rig, mw.load_model(folder / "model.json"), mw.staircase(), on_sample=enough)
    except EnoughError:
        pass
    files = {getattr(module, "__file__", None) for name, module in sys.modules.items() if name.startswith("musclewire")}
    core = [
        Path(file) for file in files if file and Path(file).is_relative_to(PACKAGE) and "extras" not in Path(file).parts
    ]
    return {"control_files": len(core), "control_lines": lines_in(core)}


def recorded_loop(folder: Path) -> dict[str, int]:
    """Record the loop and fit the model that the journeys begin with; nothing is counted."""
    import musclewire as mw

    with mw.open_rig("simulated", seed=1) as rig:
        mw.fit(mw.characterize(rig, path=folder / "loop.h5")).save(folder / "model.json")
    return {}


PARTS: dict[str, Callable[[Path], dict[str, int]]] = {
    "recorded_loop": recorded_loop,
    "journeys": journeys,
    "imports_of_control": imports_of_control,
}


def sizes() -> dict[str, int]:
    """Return all sizes; what is entered and imported is looked at in processes of their own."""
    found = static_sizes() | {"names_over_walls": names_over_walls()}
    with tempfile.TemporaryDirectory() as folder:
        for part in PARTS:
            where = os.pathsep.join((str(PACKAGE.parent), str(ROOT)))
            plain = {"NUMBA_DISABLE_JIT": "1"} if part == "journeys" else {}
            command = [sys.executable, __file__, "--part", part, folder]
            done = subprocess.run(
                command, env={**os.environ, "PYTHONPATH": where, **plain}, capture_output=True, text=True, check=False
            )
            if done.returncode != 0:
                sys.exit(f"{part} cannot be counted:\n{done.stderr}")
            found |= json.loads(done.stdout)
    return found


def changed(changes: Mapping[str, int]) -> tuple[list[str], list[str]]:
    """Return the names of the held sizes that have risen, and of those that have fallen."""
    held = {name: change for name, change in changes.items() if name not in NOT_HELD}
    return [name for name, change in held.items() if change > 0], [name for name, change in held.items() if change < 0]


def main() -> int:
    """Print the sizes beside their record; return 1 if one has risen."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print the sizes as one document, and judge nothing")
    parser.add_argument("--record", action="store_true", help="write the sizes as the record")
    parser.add_argument("--part", nargs=2, metavar=("PART", "FOLDER"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.part:
        part, folder = arguments.part
        print(json.dumps(PARTS[part](Path(folder))))
        return 0
    found = sizes()
    if arguments.json:
        print(json.dumps(found, indent=2))
        return 0
    head = RECORD.read_text("utf-8").partition("\n\n")[0] if RECORD.is_file() else "# Sizes of the house."
    record = tomllib.loads(RECORD.read_text("utf-8")) if RECORD.is_file() else {}
    if arguments.record:
        RECORD.write_text(f"{head}\n\n" + "".join(f"{name} = {found[name]}\n" for name in found), encoding="utf-8")
    if unknown := set(record) ^ set(found) if not arguments.record else set():
        print(f"{RECORD.name} and what is counted differ in {', '.join(sorted(unknown))}: record the sizes")
        return 1
    changes = {name: found[name] - record.get(name, found[name]) for name in found}
    risen, fallen = changed(changes)
    for name, size in found.items():
        change = changes[name]
        said = "not held" if name in NOT_HELD else f"{change:+d}" if change else ""
        print(f"{size:8,d}  {name:24s}{said}".rstrip())
    if arguments.record:
        return 0
    if fallen:
        print(f"fallen: {', '.join(fallen)}: keep it by 'python checks/size.py --record', in the same commit")
    if risen:
        cure = "take as much away elsewhere, or raise the record in a commit of its own that says what it bought"
        print(f"risen: {', '.join(risen)}: {cure}")
    return 1 if risen else 0


if __name__ == "__main__":
    sys.exit(main())
