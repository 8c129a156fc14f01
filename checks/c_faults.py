"""Small faults in C, of the kinds that cosmic-ray makes in Python, for checks/mutation.py.

They are found in the text, before the preprocessor: what has blanks on both sides is a binary operator, as clang-format
writes it. A statement that is deleted becomes an empty block. What then does not compile, with warnings as errors, is
no fault that a test has to find: ``compiler`` tells. Code of test images alone (MW_FAULT_INJECTION) is left out.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

INSTEAD = {
    "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "+": "-", "-": "+", "*": "/", "/": "*",
    "+=": "-=", "-=": "+=", "&&": "||", "||": "&&", "true": "false", "false": "true", "break": "continue",
    "continue": "break",
}  # fmt: skip
NOT_CODE = re.compile(
    r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"|^\#ifdef MW_FAULT_INJECTION\n.*?^\#endif|^\#define \w+|^\#(?!define)[^\n]*',
    re.S | re.M,
)
OPERATOR = re.compile(r"(?<=\s)(?:[<>=!+-]=|&&|\|\||[-+*/<>])(?=\s)|\b(?:true|false|break|continue)\b")
UNARY = re.compile(r"!(?=[\w(])|(?<=[\s(])-(?=[\w(])")
NUMBER = re.compile(r"(?<![\w.])(0x[0-9a-f]+|\d+\.?\d*(?:e-?\d+)?)([uf]?)\b")
CONDITION = re.compile(r"\b(?:if|while) (?=\()")
LOOP = re.compile(r"\bfor \([^;]*;([^;]*);")
# Begun where another has ended, a bracket closed or an else stands; indented, and more than a declaration.
STATEMENT = re.compile(
    r"(?:[;{}):]|\belse)\s*\n[ \t]+"
    r"((?!(?:return|if|for|while|case|else)\b|\(void\)\w+;)[\w(*][^;{}]*[=(+-][^;{}]*;)"
)
STRICT = ("-std=gnu99", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-Wno-unknown-pragmas")


class Fault(NamedTuple):
    """A stretch of a file's text and what stands there instead."""

    kind: str
    start: int
    end: int
    instead: str


def only_code(text: str) -> str:
    """Return a text with blanks where it is no code, as long as before."""
    return NOT_CODE.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def faults_in(text: str) -> Iterator[Fault]:
    """Yield all faults of a file's text."""
    code = only_code(text)
    for found in OPERATOR.finditer(code):
        yield Fault(f"{found[0]} to {INSTEAD[found[0]]}", *found.span(), INSTEAD[found[0]])
    for found in UNARY.finditer(code):
        yield Fault(f"without {found[0]}", *found.span(), "")
    for found in NUMBER.finditer(code):
        for step in (1, -1):
            if (number := another(*found.groups(), step)) is not None:
                yield Fault(f"number {step:+}", *found.span(), number)
    for found in CONDITION.finditer(code):
        end = closing(code, found.end())
        yield Fault("not", found.end(), end, f"(!{text[found.end() : end]})")
    for found in LOOP.finditer(code):
        yield Fault("loop without a round", *found.span(1), " 0")
    position = 0  # what ends a statement may begin the next match
    while found := STATEMENT.search(code, position):
        yield Fault("without the statement", *found.span(1), "{ }")
        position = found.start(1)


def another(number: str, suffix: str, step: int) -> str | None:
    """Return a number's text with 1 more or less; None below 0 where it has no sign."""
    if "." in number or ("e" in number and "x" not in number):
        return f"{float(number) + step!r}{suffix}"
    value = int(number, 0) + step
    return None if value < 0 and suffix == "u" else f"{value}{suffix}"


def closing(code: str, start: int) -> int:
    """Return where the bracket that opens at a place has been closed."""
    depth = 0
    for at in range(start, len(code)):
        depth += {"(": 1, ")": -1}.get(code[at], 0)
        if depth == 0:
            return at + 1
    raise ValueError(f"a bracket stays open: {code[start : start + 60]!r}")


def changed(text: str, occurrence: int) -> str:
    """Return a text with the how manyth of its faults."""
    fault = list(faults_in(text))[occurrence]
    return text[: fault.start] + fault.instead + text[fault.end :]


def compiler(tree: Path, folder: Path) -> Callable[[Path, str], bool]:
    """Return a function that tells whether a file of a checkout's C compiles with a text; a folder keeps headers."""
    build = tree / "firmware/build.py"
    exported = f"import sys; sys.path[:0] = [{str(build.parent)!r}]; import build; build.write_sources('mps2-an386', "
    variables = {**os.environ, "PYTHONPATH": str(tree / "src")}
    command = [sys.executable, "-P", "-c", f"{exported}build.Path({str(folder)!r}))"]
    subprocess.run(command, env=variables, check=True)
    places = [f"-I{place}" for place in (tree / "firmware/src", folder / "src")]

    def compiles(file: Path, text: str) -> bool:
        command = ["gcc", *STRICT, *places, f"-I{file.parent}", "-xc", "-", "-c", "-o", os.devnull]
        forms = ([], ["-DMW_STANDALONE"])
        runs = (subprocess.run([*command, *more], input=text.encode(), capture_output=True) for more in forms)
        return all(run.returncode == 0 for run in runs)

    return compiles
