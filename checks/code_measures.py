"""Measure how long functions are, and judge it.

    python checks/code_measures.py [FOLDER]

FOLDER is src/musclewire unless another is given. A function's length is its code lines: lines with code from ``def`` to
its end, without docstring, comments and blank lines; protocol methods that only have a docstring do not count. Ends
with exit code 1 if anything is over its limit. How branched a function may be is ruff's rule C901.
"""

from __future__ import annotations

import argparse
import ast
import io
import math
import sys
import tokenize
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

MAX_P95_LINES = 22
MAX_FUNCTION_LINES = 50

NO_CODE = frozenset({
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER,
})  # fmt: skip
SOURCES = Path(__file__).resolve().parents[1] / "src" / "musclewire"


@dataclass(frozen=True)
class Function:
    """A function with its place and its code lines."""

    path: Path
    line: int
    name: str
    lines: int

    def __str__(self) -> str:
        """Return place and name, with the measure."""
        return f"{self.path}:{self.line} {self.name}: {self.lines} code lines"


@dataclass(frozen=True)
class Measures:
    """All functions of a folder."""

    functions: Sequence[Function]

    @property
    def p95_lines(self) -> int:
        """The 95th percentile of the functions' code lines: the least length that 95 % do not exceed."""
        lengths = sorted(function.lines for function in self.functions)
        return lengths[math.ceil(0.95 * len(lengths)) - 1]

    @property
    def long(self) -> list[Function]:
        """The functions over the longest permitted, longest first."""
        return sorted((one for one in self.functions if one.lines > MAX_FUNCTION_LINES), key=lambda one: -one.lines)


def measure(folder: Path) -> Measures:
    """Return the measures of all Python files below a folder."""
    paths = sorted(folder.rglob("*.py"))
    return Measures([one for path in paths for one in functions_of(path.relative_to(folder), path.read_text("utf-8"))])


def functions_of(path: Path, text: str) -> Iterator[Function]:
    """Yield the functions of a file that have code, nested ones too."""
    with_code = lines_with_code(text)
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) or only_constants(node):
            continue
        assert node.end_lineno is not None  # parsed from text
        lines = with_code.intersection(range(node.lineno, node.end_lineno + 1)) - docstring_lines(node)
        yield Function(path, node.lineno, node.name, len(lines))


def lines_with_code(text: str) -> set[int]:
    """Return the numbers of the lines that any code is on, docstrings included."""
    found: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in NO_CODE:
            found.update(range(token.start[0], token.end[0] + 1))
    return found


def only_constants(node: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Return whether a body is a docstring or an ellipsis: a declaration."""
    return all(isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant) for item in node.body)


def docstring_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> set[int]:
    """Return the numbers of a function's docstring lines."""
    if ast.get_docstring(node, clean=False) is None:
        return set()
    first = node.body[0]
    assert first.end_lineno is not None  # parsed from text
    return set(range(first.lineno, first.end_lineno + 1))


def problems_of(measures: Measures) -> list[str]:
    """Return in words what is over its limit."""
    found = [f"{one}: over {MAX_FUNCTION_LINES} lines; split it" for one in measures.long]
    if measures.p95_lines > MAX_P95_LINES:
        found.append(f"the 95th percentile is {measures.p95_lines} code lines, over {MAX_P95_LINES}: split functions")
    return found


def summary(measures: Measures) -> str:
    """Return the measures beside their limits, as lines."""
    longest = max(measures.functions, key=lambda one: one.lines)
    over = sum(one.lines > MAX_P95_LINES for one in measures.functions)
    return "\n".join([
        f"{len(measures.functions)} functions",
        f"95th percentile of code lines: {measures.p95_lines} (at most {MAX_P95_LINES}); {over} functions over that",
        f"over {MAX_FUNCTION_LINES} code lines: {len(measures.long)}; longest: {longest}",
    ])  # fmt: skip


def main() -> int:
    """Print measures and problems; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?", default=SOURCES)
    parser.add_argument("--list", action="store_true", help=f"also list the functions over {MAX_P95_LINES} code lines")
    arguments = parser.parse_args()
    measures = measure(arguments.folder)
    print(summary(measures))
    if arguments.list:
        for one in sorted(measures.functions, key=lambda one: -one.lines):
            if one.lines > MAX_P95_LINES:
                print(f"  {one}")
    problems = problems_of(measures)
    print("\n".join(problems) or "nothing is over its limit")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
