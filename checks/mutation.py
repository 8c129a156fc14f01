"""Mutation testing: how many small faults in the code the tests find. Those in Python are cosmic-ray's.

    python checks/mutation.py [--sample 60] [--seed 1] [--places core protection live] [--tests PATH ...]
                              [--tree CHECKOUT] [--keep FOLDER]

Each place gives an equal part of the sample: the core, the protection with the guard, the live server, the guardian of
NI's cards, and what the firmware's C keeps safe: protection, loop, commands, host's silence, stand-alone button.

In Python pytest-cov first measures which test runs which line, once with compilation and once, for kernels, without;
``--tests`` are measured, slow ones too, and not those that a run without names runs. Each mutant is judged by the
quickest tests that run its line, together at most BUDGET_S, until one fails; one that no test runs has survived, one
whose tests do not end is found. The processes that a test starts have the fault, too. ``--keep`` keeps what was
measured for the next call with the same sources and tests.

In C (c_faults.py) all TESTS_OF_C judge, in a copy of the checkout, which they compile: on this machine first, then for
an emulated board.

Prints every survivor with its change; ``--tree`` judges another checkout. No exit code judges: read each survivor, and
write the test that finds it, by an oracle or a property rather than by the number that comes out.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import c_faults
from cosmic_ray.ast import get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from coverage import CoverageData

CHECKOUT = Path(__file__).resolve().parents[1]
PROTECTION = (
    "controllers/_protection",
    "rigs/_guarded.py",
    "rigs/_two_clocks.py",
    "rigs/_remembered_temperature.py",
    "experiment/_calm_air.py",
)
CORE = ("wire", "sensing", "controllers", "rigs", "signals", "files", "judge", "identify", "experiment", "parameters")
GUARDIAN = ("extras/board/_nidaq/guardian.py",)
FIRMWARE = (
    *(f"extras/board/c_library/mw_{name}.c" for name in ("protect", "controller", "sensing")),
    *(f"../../firmware/src/{name}.c" for name in ("application", "control", "framing", "standalone", "main")),
    *(f"../../firmware/src/{name}.h" for name in ("application", "control")),
)
PLACES = {
    "core": CORE,
    "protection": PROTECTION,
    "live": ("extras/live",),
    "guardian": GUARDIAN,
    "firmware": FIRMWARE,
}
# In this order: what compiles and runs in seconds, then a board in an emulator.
TESTS_OF_C = (
    "tests/extras/board/firmware/test_parts_on_the_host.py",
    "tests/extras/board/export/test_protection_in_c.py",
    "tests/extras/board/export/test_c_equals_python.py",
    "tests/extras/board/export/test_filter_in_c.py",
    "tests/extras/board/firmware/test_the_emulated_board.py",
)
# Compiled code cannot be traced: these run it in plain Python, those of them that take at most a few seconds so.
WITHOUT_COMPILATION = (
    "tests/unit/controllers",
    "tests/unit/sensing",
    "tests/unit/wire",
    "tests/unit/physics",
    "tests/contract",
)
LIMIT_S = 4.0
BUDGET_S, BEGIN_S = 20.0, 120.0
# All tests of C take a minute on a quiet machine.
IN_C_S = 600.0
NOT_JUDGES = "not full and not browser and not documented and not oracles"
# As sitecustomize, which Python imports as it begins: the processes that a test starts have the fault, too.
IN_EVERY_PROCESS = "import sys\nif 'checks.mutated' not in sys.orig_argv:\n    import checks.mutated\n"
OPERATORS = (
    "ReplaceBinaryOperator_Add_Sub", "ReplaceBinaryOperator_Sub_Add", "ReplaceBinaryOperator_Mul_Div",
    "ReplaceBinaryOperator_Div_Mul", "ReplaceComparisonOperator_Lt_LtE", "ReplaceComparisonOperator_LtE_Lt",
    "ReplaceComparisonOperator_Gt_GtE", "ReplaceComparisonOperator_GtE_Gt", "ReplaceComparisonOperator_Eq_NotEq",
    "ReplaceComparisonOperator_NotEq_Eq", "ReplaceComparisonOperator_Is_IsNot", "ReplaceComparisonOperator_IsNot_Is",
    "ReplaceUnaryOperator_Delete_USub", "ReplaceUnaryOperator_Delete_Not", "AddNot", "ReplaceTrueWithFalse",
    "ReplaceFalseWithTrue", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceBreakWithContinue",
    "ReplaceContinueWithBreak", "NumberReplacer", "ZeroIterationForLoop",
)  # fmt: skip


class Mutant(NamedTuple):
    """One change of a file: which operator, the how manyth place that it can change, and that place's line."""

    path: Path
    operator: str
    occurrence: int
    line: int


class Measured(NamedTuple):
    """Which tests run each line of each file, and what each test takes [s], in one mode of compilation."""

    tests: dict[str, dict[int, list[str]]]
    seconds: dict[str, float]


def mutants_in(tree: Path, places: tuple[str, ...]) -> Iterator[Mutant]:
    """Yield all mutants of files and folders of the package."""
    for place in places:
        path = (tree / "src/musclewire" / place).resolve()
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            if places is PLACES["core"] and any(protection in str(file) for protection in PROTECTION):
                continue
            if file.suffix != ".py":
                yield from mutants_in_c(file)
                continue
            module = get_ast(file.read_text("utf-8"))
            for name in OPERATORS:
                for occurrence, line in enumerate(lines_changed_by(name, module)):
                    yield Mutant(file, name, occurrence, line)


def mutants_in_c(file: Path) -> Iterator[Mutant]:
    """Yield all mutants of a file in C."""
    text = file.read_text("utf-8")
    for occurrence, fault in enumerate(c_faults.faults_in(text)):
        yield Mutant(file, fault.kind, occurrence, text.count("\n", 0, fault.start) + 1)


def lines_changed_by(name: str, module: object) -> Iterator[int]:
    """Yield the line of each place that an operator can change, in cosmic-ray's order."""
    operator, waiting = get_operator(f"core/{name}")(), [module]
    while waiting:
        node = waiting.pop()
        for start, _ in operator.mutation_positions(node):
            yield start[0]
        waiting += reversed(getattr(node, "children", ()))


def environment(tree: Path, compiled: bool, **more: str) -> dict[str, str]:
    """Return the variables of a run of tests."""
    plain = {} if compiled else {"NUMBA_DISABLE_JIT": "1"}
    return {**os.environ, "PYTHONPATH": f"{tree / 'src'}:{tree}:{CHECKOUT}", "MPLBACKEND": "Agg", **plain, **more}


def measured(tree: Path, folder: Path, compiled: bool, tests_that_judge: list[str]) -> Measured:
    """Run the tests under coverage and return which runs what; what a folder holds is not measured again."""
    name = "compiled" if compiled else "plain"
    data, seconds = folder / f"{name}.coverage", folder / f"{name}.json"
    if not seconds.exists():
        # For threads coverage holds a lock, and a test that ends at its limit while it is held never ends.
        no_threads = folder / "plain.ini"
        no_threads.write_text("[run]\nconcurrency = multiprocessing\n", "utf-8")
        quick = [test for test in tests_that_judge if test.startswith(WITHOUT_COMPILATION)] or WITHOUT_COMPILATION
        limited = ["--timeout", str(LIMIT_S), f"--cov-config={no_threads}", *quick]
        named = ["-m", NOT_JUDGES, *tests_that_judge] if tests_that_judge else []
        chosen = named if compiled else limited
        command = ["-m", "pytest", "-q", "-n", "auto", "-p", "checks.mutated", f"--cov={tree / 'src/musclewire'}"]
        options = ["--cov-context=test", "--cov-report=", "-p", "no:cacheprovider", "-o", "filterwarnings=default"]
        variables = environment(tree, compiled, COVERAGE_FILE=str(data), DURATIONS=str(seconds))
        print(f"measuring, {'with' if compiled else 'without'} compilation", flush=True)
        subprocess.run([sys.executable, *command, *options, *chosen], cwd=tree, env=variables, capture_output=True)
    covered = CoverageData(no_disk=True)
    for part in folder.glob(f"{data.name}*"):  # without threads each process leaves a file of its own
        one = CoverageData(str(part))
        one.read()
        covered.update(one)
    tests = {path: covered.contexts_by_lineno(path) for path in covered.measured_files()}
    in_tests = {
        path: {line: [test.partition("|")[0] for test in names if test] for line, names in lines.items()}
        for path, lines in tests.items()
    }
    return Measured(in_tests, json.loads(seconds.read_text("utf-8")))


def in_kernel(mutant: Mutant) -> bool:
    """Return whether compiled code has a mutant's line: in a compiled function, or as a constant of its file."""
    module = ast.parse(mutant.path.read_text("utf-8"))
    functions = [node for node in ast.walk(module) if isinstance(node, ast.FunctionDef)]
    kernels = [node for node in functions if any("compiled" in ast.unparse(mark) for mark in node.decorator_list)]
    inside = [node for node in functions if node.lineno <= mutant.line <= (node.end_lineno or 0)]
    return any(node in kernels for node in inside) or bool(kernels and not inside)


def judges(mutant: Mutant, found: Measured) -> list[str]:
    """Return the tests that judge a mutant: the quickest of those that run its line, or else its file."""
    lines = found.tests.get(str(mutant.path), {})
    tests = set(lines.get(mutant.line, ())) or {test for names in lines.values() for test in names}
    chosen, total_s = [], 0.0
    for test in sorted(tests, key=lambda test: found.seconds.get(test, float("inf"))):
        total_s += found.seconds.get(test, float("inf"))
        if total_s > BUDGET_S:
            break
        chosen.append(test)
    return chosen


def changed(mutant: Mutant) -> str:
    """Return the text of a mutant's file."""
    before = mutant.path.read_text("utf-8")
    if mutant.path.suffix != ".py":
        return c_faults.changed(before, mutant.occurrence)
    return str(mutate_code(before, get_operator(f"core/{mutant.operator}")(), mutant.occurrence))


def drawn(tree: Path, place: str, count: int, draw: random.Random) -> list[Mutant]:
    """Draw mutants of a place; in C of those that compile."""
    every = list(mutants_in(tree, PLACES[place]))
    if place != "firmware":
        return draw.sample(every, count)
    with tempfile.TemporaryDirectory() as folder:
        compiles = c_faults.compiler(tree, Path(folder))
        sound = (mutant for mutant in draw.sample(every, len(every)) if compiles(mutant.path, changed(mutant)))
        return list(islice(sound, count))


def judged_in_c(mutant: Mutant, tree: Path) -> tuple[int, str]:
    """Return the exit code of the tests of C in a copy of the checkout with a fault, and who judged."""
    listing = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    names = subprocess.run(listing, cwd=tree, capture_output=True, text=True, check=True).stdout.split("\0")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, tree.name)
        for name in filter(None, names):
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(tree / name, copy / name)
        (copy / mutant.path.relative_to(tree)).write_text(changed(mutant), "utf-8")
        command = [sys.executable, "-m", "pytest", "-xq", "-m", f"{NOT_JUDGES} and not slow", "-p", "no:cacheprovider"]
        variables = environment(copy, compiled=True)
        return ended([*command, *TESTS_OF_C], copy, variables, IN_C_S), f"all of {len(TESTS_OF_C)} files of tests pass"


def ended(command: list[str], folder: Path, variables: dict[str, str], limit_s: float) -> int:
    """Return the exit code of tests, 1 if they do not end."""
    try:
        return subprocess.run(command, cwd=folder, env=variables, capture_output=True, timeout=limit_s).returncode
    except subprocess.TimeoutExpired:
        return 1


def judged_in_python(mutant: Mutant, tree: Path, found: dict[bool, Measured]) -> tuple[int, str]:
    """Return the exit code of the tests that judge a mutant, 0 without any, and who judged."""
    compiled = not in_kernel(mutant)
    tests = judges(mutant, found[compiled])
    if not tests:
        return 0, "no test runs it"
    with tempfile.TemporaryDirectory() as folder:
        text = Path(folder, "changed.py")
        text.write_text(changed(mutant), "utf-8")
        Path(folder, "sitecustomize.py").write_text(IN_EVERY_PROCESS, "utf-8")
        variables = environment(tree, compiled, MUTATED=f"{mutant.path}{os.pathsep}{text}")
        variables["PYTHONPATH"] = f"{folder}:{variables['PYTHONPATH']}"
        command = [sys.executable, "-m", "pytest", "-xq", "-p", "checks.mutated", "-p", "no:cacheprovider", *tests]
        return ended(command, tree, variables, BEGIN_S), f"{len(tests)} tests pass"


def survives(mutant: Mutant, tree: Path, found: dict[bool, Measured]) -> str:
    """Return how a mutant survived, with its change; "" if a test found it."""
    in_python = mutant.path.suffix == ".py"
    code, how = judged_in_python(mutant, tree, found) if in_python else judged_in_c(mutant, tree)
    before, after = mutant.path.read_text("utf-8").splitlines(), changed(mutant).splitlines()
    lines = difflib.unified_diff(before, after, lineterm="", n=0)
    words = "\n    ".join(line for line in lines if line[:3] not in ("---", "+++"))
    return "" if code else f"{mutant.path.relative_to(tree)}:{mutant.line} {mutant.operator}: {how}\n    {words}"


def main() -> None:
    """Draw, measure, judge, and print the survivors."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sample", type=int, default=60, help="how many mutants, as many of each place")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--places", nargs="+", choices=PLACES, default=["core", "protection", "live"])
    parser.add_argument("--tests", nargs="+", default=[], metavar="PATH", help="tests that may judge")
    parser.add_argument("--tree", type=Path, default=CHECKOUT, help="checkout that is judged")
    parser.add_argument("--keep", type=Path, help="folder of what was measured")
    given = parser.parse_args()
    tree, draw = given.tree.resolve(), random.Random(given.seed)
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        modes = (True, False) if set(given.places) != {"firmware"} else ()
        found = {compiled: measured(tree, folder, compiled, given.tests) for compiled in modes}
        for place in given.places:
            chosen = drawn(tree, place, given.sample // len(given.places), draw)
            with ThreadPoolExecutor(os.cpu_count()) as threads:
                results = list(threads.map(lambda mutant: survives(mutant, tree, found), chosen))
            survivors = [words for words in results if words]
            print(f"{place}: {len(survivors)} of {len(chosen)} survive", *survivors, sep="\n", flush=True)


if __name__ == "__main__":
    main()
