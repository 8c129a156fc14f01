"""Mutation testing: how many small faults in the code the tests find. The faults are cosmic-ray's.

    python checks/mutation.py [--sample 60] [--seed 1] [--places core protection live] [--tests PATH ...]
                              [--tree CHECKOUT] [--keep FOLDER]

Each place gives an equal part of the sample: the core, the protection with the guard, the live server, the guardian of
NI's cards. First pytest-cov measures which test runs which line, once with compilation and once, for kernels, without;
``--tests`` are measured, slow ones too, and not those that a run without names runs. Each mutant is judged by the
quickest tests that run its line, together at most BUDGET_S, until one fails; one that no test runs has survived, one
whose tests do not end is found. The processes that a test starts have the fault, too. Prints every survivor with its
change. ``--keep`` keeps what was measured for the next call with the same sources and tests; ``--tree`` judges another
checkout. No exit code judges: read each survivor, and write the test that finds it, by an oracle or a property rather
than by the number that comes out.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import json
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from cosmic_ray.ast import get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from coverage import CoverageData

CHECKOUT = Path(__file__).resolve().parents[1]
PROTECTION = ("controllers/_protection", "rigs/_guarded.py", "rigs/_two_clocks.py")
CORE = ("wire", "sensing", "controllers", "rigs", "signals", "identify", "experiment", "parameters")
GUARDIAN = ("extras/board/_nidaq/guardian.py",)
PLACES = {"core": CORE, "protection": PROTECTION, "live": ("extras/live",), "guardian": GUARDIAN}
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
        path = tree / "src/musclewire" / place
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            if places is PLACES["core"] and any(protection in str(file) for protection in PROTECTION):
                continue
            module = get_ast(file.read_text("utf-8"))
            for name in OPERATORS:
                for occurrence, line in enumerate(lines_changed_by(name, module)):
                    yield Mutant(file, name, occurrence, line)


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


def survives(mutant: Mutant, tree: Path, found: dict[bool, Measured]) -> str:
    """Return how a mutant survived, with its change; "" if a test found it."""
    compiled = not in_kernel(mutant)
    before = mutant.path.read_text("utf-8")
    after = mutate_code(before, get_operator(f"core/{mutant.operator}")(), mutant.occurrence)
    tests = judges(mutant, found[compiled])
    code, how = 0, f"{len(tests)} tests pass" if tests else "no test runs it"
    if tests:
        with tempfile.TemporaryDirectory() as folder:
            text = Path(folder, "changed.py")
            text.write_text(after, "utf-8")
            Path(folder, "sitecustomize.py").write_text(IN_EVERY_PROCESS, "utf-8")
            variables = environment(tree, compiled, MUTATED=f"{mutant.path}{os.pathsep}{text}")
            variables["PYTHONPATH"] = f"{folder}:{variables['PYTHONPATH']}"
            command = [sys.executable, "-m", "pytest", "-xq", "-p", "checks.mutated", "-p", "no:cacheprovider", *tests]
            try:
                code = subprocess.run(command, cwd=tree, env=variables, capture_output=True, timeout=BEGIN_S).returncode
            except subprocess.TimeoutExpired:
                code = 1
    change = difflib.unified_diff(before.splitlines(), after.splitlines(), lineterm="", n=0)
    words = "\n    ".join(line for line in change if line[:3] not in ("---", "+++"))
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
        found = {compiled: measured(tree, folder, compiled, given.tests) for compiled in (True, False)}
        for place in given.places:
            chosen = draw.sample(list(mutants_in(tree, PLACES[place])), given.sample // len(given.places))
            with ThreadPoolExecutor(os.cpu_count()) as threads:
                results = list(threads.map(lambda mutant: survives(mutant, tree, found), chosen))
            survivors = [words for words in results if words]
            print(f"{place}: {len(survivors)} of {len(chosen)} survive", *survivors, sep="\n", flush=True)


if __name__ == "__main__":
    main()
