"""Mutation testing: how many small faults in the code of four rooms the tests find.

    python checks/mutation.py                 # a sample of 300, the same every time
    python checks/mutation.py --sample 60 --seed 2
    python checks/mutation.py --all
    python checks/mutation.py --again         # judge only those again that were not killed
    python checks/mutation.py --quick         # 6 of two files

A copy of the tree is measured once: which test runs which line, and how long it takes, with compilation on and off.
Each mutant is then judged in a process of its own by the tests that run its statement, the quickest first, until one
fails or the next would exceed ``--budget`` seconds of processor time for all. A mutant of compiled code is judged with
compilation off, and so are constants that compiled code copies. A mutant whose tests do not end counts as killed; one
that no test runs counts as survived. Verdicts are written to a journal in ``--folder`` as they come: the same command
goes on after an interruption. A test that fails in such a process without any change does not judge.

Mutants that no test can find are listed in ``mutants/equivalents.toml`` with the reason. Ends with exit code 1 if less
than 85 % of the others are killed.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
import threading
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Empty, Queue
from typing import Any, ClassVar

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from checks.mutants.choosing import Measured, Sources  # noqa: E402
from checks.mutants.measuring import measured_tests  # noqa: E402
from checks.mutants.operators import Mutant, mutants_of  # noqa: E402
from checks.mutants.tree import copied_tree, environment_of  # noqa: E402

ROOMS = ("wire", "sensing", "controllers", "rigs")
PACKAGE = Path("src", "musclewire")
EQUIVALENTS = Path(__file__).parent / "mutants" / "equivalents.toml"
MIN_KILLED = 0.85
SAMPLE, SEED = 300, 1
# Tests in the processor time that a mutant may take [s]; a survivor takes all of it.
BUDGET_S = 10.0
# A mutant may be slower than what was measured, and its process begins by importing the tests [s].
SLOWER, BEGIN_S = 5.0, 20.0
QUICK_FILES = ("controllers/protection/protect.py", "sensing/gaps.py")
QUICK_TESTS = (
    "tests/unit/controllers/test_protection.py",
    "tests/unit/controllers/test_protection_at_its_limits.py",
    "tests/unit/sensing/test_gaps.py",
)
KILLED, TIMED_OUT, SURVIVED, NOT_COVERED, EQUIVALENT = "killed", "timed out", "survived", "not covered", "equivalent"
VERDICTS = (KILLED, TIMED_OUT, SURVIVED, NOT_COVERED, EQUIVALENT)


def main() -> int:
    """Judge mutants and print the shares; return the exit code."""
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").split("\n\n")[0], epilog=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--all", action="store_true", help="judge every mutant, not a sample")
    parser.add_argument("--sample", type=int, default=SAMPLE, help=f"number of mutants ({SAMPLE})")
    parser.add_argument("--seed", type=int, default=SEED, help=f"seed of the sample ({SEED})")
    parser.add_argument("--again", action="store_true", help="judge those again that the journal has as not killed")
    parser.add_argument("--quick", action="store_true", help="6 mutants of two files by the tests of these")
    parser.add_argument("--budget", type=float, default=BUDGET_S, help=f"tests of a mutant [s of CPU] ({BUDGET_S:g})")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="how many side by side (all cores)")
    parser.add_argument(
        "--folder", type=Path, help="where copy, measurement and journal are kept (a folder of the temporary ones)"
    )
    arguments = parser.parse_args()
    if arguments.quick:
        with tempfile.TemporaryDirectory() as folder:
            return run(arguments, Path(folder))
    return run(arguments, arguments.folder or Path(tempfile.gettempdir(), "musclewire-mutation"))


def run(arguments: argparse.Namespace, folder: Path) -> int:
    """Judge a sample with all files in a folder, and print it."""
    tree = copied_tree(ROOT, folder / "tree")
    sources = Sources(tree, PACKAGE)
    files = QUICK_FILES if arguments.quick else None
    every = mutants_of_rooms(tree, files)
    equivalents = listed_equivalents(every)
    size = 6 if arguments.quick else len(every) if arguments.all else arguments.sample
    chosen = sample_of(every, size, arguments.seed)
    files_with = len({one.path for one in every})
    print(f"{len(every)} mutants of {files_with} files; {len(chosen)} of them, seed {arguments.seed}", flush=True)
    modes = sorted({sources.mode_of(one) for one in chosen})
    tests = QUICK_TESTS if arguments.quick else None
    measured = {
        mode: Measured(measured_tests(mode, tree, folder, arguments.processes, tests), sources) for mode in modes
    }
    for mode, found in measured.items():
        long = sum("too long" in why for why in found.left_out.values())
        print(
            f"compilation {'off' if mode == 'plain' else 'on'}: {len(found.cpu_s)} tests judge; left out: {long} that"
        )
        print(f"  take too long, {len(found.left_out) - long} that cannot run so")
    journal = Journal(folder / "journal.jsonl", again=arguments.again)
    judge_all(chosen, (sources, measured, equivalents), arguments, tree, journal)
    return report(chosen, journal)


def mutants_of_rooms(tree: Path, files: Sequence[str] | None = None) -> list[Mutant]:
    """Return the mutants of all files of the rooms, or of some files."""
    found: list[Mutant] = []
    for room in ROOMS:
        for path in sorted((tree / PACKAGE / room).rglob("*.py")):
            if files is None or str(path.relative_to(tree / PACKAGE)) in files:
                found += mutants_of(str(path.relative_to(tree)), path.read_text(encoding="utf-8"))
    return found


def sample_of(every: Sequence[Mutant], size: int, seed: int) -> list[Mutant]:
    """Return a systematic sample: every n-th of all, by room, operator, file and place, from a random first one on.

    Each room, each operator within it and each file have their part of it; a chance within each cell of the grid keeps
    neighbouring places from always being left out together. The order in which they are judged is by chance, so that
    what an interrupted run has judged is a sample, too.
    """
    ordered = sorted(every, key=lambda one: (one.path.split("/")[2], one.operator, one.path, one.place, one.after))
    if size >= len(ordered):
        return ordered
    chance = random.Random(seed)
    step = len(ordered) / size
    found = [ordered[min(int((cell + chance.random()) * step), len(ordered) - 1)] for cell in range(size)]
    chance.shuffle(found)
    return found


def equivalent_entries(path: Path) -> list[dict[str, str]]:
    """Return the entries of the list of equivalents: path, text of the line, operator, change and reason."""
    found: list[dict[str, str]] = tomllib.loads(path.read_text(encoding="utf-8")).get("equivalent", [])
    return found


def listed_equivalents(every: Iterable[Mutant]) -> dict[str, str]:
    """Return the reasons of the mutants that are listed as equivalent, by their keys; say which entries match none."""
    entries = equivalent_entries(EQUIVALENTS)
    reasons = {(one["path"], one["text"], one["operator"], one["change"]): one["reason"] for one in entries}
    found, matched = {}, set()
    for mutant in every:
        identity = (str(Path(mutant.path).relative_to(PACKAGE)), mutant.text, mutant.operator, mutant.change)
        if identity in reasons:
            found[mutant.key] = reasons[identity]
            matched.add(identity)
    for path, text, operator, change in reasons.keys() - matched:
        print(f"listed as equivalent, but not in the source any more: {path} {operator} {change} in {text}")
    return found


class Journal:
    """Verdicts, written as they come, by the file's text, the place and the change."""

    def __init__(self, path: Path, *, again: bool) -> None:
        """Read what there is; with ``again`` only the killed count as judged."""
        self._path, self._lock = path, threading.Lock()
        self.verdicts: dict[str, dict[str, Any]] = {}
        if path.exists():
            for line in path.read_text(encoding="utf-8").splitlines():
                entry = json.loads(line)
                self.verdicts[entry["key"]] = entry
        if again:
            self.verdicts = {key: one for key, one in self.verdicts.items() if one["verdict"] in (KILLED, TIMED_OUT)}

    def add(self, entry: dict[str, Any]) -> None:
        """Keep a verdict."""
        with self._lock:
            self.verdicts[entry["key"]] = entry
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(entry) + "\n")


class Judges:
    """The processes of one thread that judge mutants, one with compilation on and one with it off, when needed."""

    # Whether a test fails without any change, by mode and name; for all threads.
    known: ClassVar[dict[tuple[str, str], bool]] = {}

    def __init__(self, tree: Path, folder: Path) -> None:
        """Take the copy of the tree and a folder for what tests write."""
        self.tree, self._folder = tree, folder
        self._running: dict[str, subprocess.Popen[str]] = {}

    def verdict(self, mode: str, job: Mapping[str, Any]) -> dict[str, Any]:
        """Return what a process says of a mutant."""
        if mode not in self._running:
            self._running[mode] = subprocess.Popen(
                [sys.executable, "-m", "checks.mutants.judging", mode, str(self._folder)],
                cwd=self.tree,
                env=environment_of(mode, self.tree),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            self._answer(mode)
        running = self._running[mode]
        assert running.stdin is not None
        running.stdin.write(json.dumps(job) + "\n")
        running.stdin.flush()
        return self._answer(mode)

    def fails_unchanged(self, mode: str, test: str, job: Mapping[str, Any]) -> bool:
        """Return whether a test fails in such a process without any change; each is tried once."""
        if (mode, test) not in self.known:
            said = self.verdict(mode, {**job, "tests": [[test]]})
            self.known[mode, test] = bool(said["timed_out"] or said["by"])
        return self.known[mode, test]

    def _answer(self, mode: str) -> dict[str, Any]:
        """Return the next line of a process. RuntimeError if it has ended."""
        running = self._running[mode]
        assert running.stdout is not None
        line = running.stdout.readline()
        if not line:
            raise RuntimeError(
                f"the process that judges mutants has ended with {running.wait()}: see its message above"
            )
        found: dict[str, Any] = json.loads(line)
        return found

    def close(self) -> None:
        """End the processes."""
        for running in self._running.values():
            assert running.stdin is not None
            running.stdin.close()
            running.wait()


def judge_all(
    chosen: Sequence[Mutant],
    known: tuple[Sources, Mapping[str, Measured], Mapping[str, str]],
    arguments: argparse.Namespace,
    tree: Path,
    journal: Journal,
) -> None:
    """Judge what the journal does not have."""
    waiting: Queue[Mutant] = Queue()
    for one in chosen:
        if known[2].get(one.key):
            journal.verdicts[one.key] = {"key": one.key, "verdict": EQUIVALENT, "why": known[2][one.key]}
        elif one.key not in journal.verdicts or journal.verdicts[one.key]["verdict"] == EQUIVALENT:
            waiting.put(one)
    total = waiting.qsize()
    if total < len(chosen):
        print(f"{len(chosen) - total} are in the journal or listed as equivalent")

    def work() -> None:
        judges = Judges(tree, tree.parent)
        try:
            while True:
                try:
                    mutant = waiting.get_nowait()
                except Empty:
                    return
                entry = judged(mutant, known[0], known[1], judges, arguments.budget)
                journal.add(entry)
                how = f"by {entry['by']}" if entry["by"] else f"{entry['tests']} tests, {entry['tests_cpu_s']:.0f} s"
                place = f"{mutant.path.removeprefix('src/musclewire/')}:{mutant.line}"
                print(
                    f"[{total - waiting.qsize()}/{total}] {entry['verdict']}: {place} {mutant.operator} {how}",
                    flush=True,
                )
        finally:
            judges.close()

    with ThreadPoolExecutor(arguments.processes) as threads:
        for thread in [threads.submit(work) for _ in range(arguments.processes)]:
            thread.result()


def judged(
    mutant: Mutant, sources: Sources, measured: Mapping[str, Measured], judges: Judges, budget_s: float
) -> dict[str, Any]:
    """Return the journal's entry of a mutant; a test that fails without the change, too, does not judge."""
    mode = sources.mode_of(mutant)
    tests = measured[mode].chosen(mutant, budget_s)
    entry = {
        "key": mutant.key, "path": mutant.path, "line": mutant.line, "operator": mutant.operator,
        "text": mutant.text, "change": mutant.change, "mode": mode, "by": "", "tests_cpu_s": tests.cpu_s,
        "tests": sum(map(len, tests.stages)),
    }  # fmt: skip
    source = (judges.tree / mutant.path).read_text(encoding="utf-8")
    job = {"path": mutant.path, "text": mutant.applied(source), "limit_s": SLOWER * tests.cpu_s + BEGIN_S}
    stages = tests.stages
    while stages:
        said = judges.verdict(mode, {**job, "tests": stages})
        if said["timed_out"] or not said["by"]:
            return {**entry, **said, "verdict": TIMED_OUT if said["timed_out"] else SURVIVED}
        suspect = suspect_of(said["by"], stages)
        if not judges.fails_unchanged(mode, suspect, {**job, "text": source}):
            return {**entry, **said, "verdict": KILLED}
        stages = [left for left in ([name for name in stage if name != suspect] for stage in stages) if left]
    return {**entry, "verdict": NOT_COVERED}


def suspect_of(by: str, stages: Sequence[Sequence[str]]) -> str:
    """Return the test that a verdict names, or the first one of the file that it names, or the first of all."""
    every = [name for stage in stages for name in stage]
    file = by.split(": ")[0]
    return next((name for name in every if name == by or name.split("::")[0] == file), every[0])


def report(chosen: Sequence[Mutant], journal: Journal) -> int:
    """Print what survived and the shares; return the exit code."""
    counts: dict[str, Counter[str]] = {room: Counter() for room in ROOMS}
    for mutant in sorted(chosen, key=lambda one: (one.path, one.place)):
        verdict = journal.verdicts[mutant.key]["verdict"]
        counts[mutant.path.split("/")[2]][verdict] += 1
        if verdict in (SURVIVED, NOT_COVERED):
            print(f"{verdict}: {mutant.path}:{mutant.line} {mutant.operator}: {mutant.change}")
    total = sum(counts.values(), Counter())
    print(f"\n{'room':12} {'mutants':>8} " + " ".join(f"{verdict:>11}" for verdict in VERDICTS) + f" {'killed':>8}")
    for room, count in {**counts, "in total": total}.items():
        numbers = " ".join(f"{count[verdict]:11d}" for verdict in VERDICTS)
        print(f"{room:12} {count.total():8d} {numbers} {share(count):8.1%}")
    print("killed: those whose tests fail or do not end, of those not listed as equivalent")
    enough = share(total) >= MIN_KILLED
    print(f"{share(total):.1%} in total, at least {MIN_KILLED:.0%} asked: {'met' if enough else 'NOT MET'}")
    return 0 if enough else 1


def share(count: Mapping[str, int]) -> float:
    """Return the killed of those not listed as equivalent; 1 if there are none."""
    judged_ones = sum(count.values()) - count[EQUIVALENT]
    return (count[KILLED] + count[TIMED_OUT]) / judged_ones if judged_ones else 1.0


if __name__ == "__main__":
    sys.exit(main())
