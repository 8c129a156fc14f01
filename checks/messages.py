"""List every message of an error or a warning in the source, by owner, and hold it to rules: what, where, what to do.

    python -m checks.messages [--list] [PATH ...]

PATH is a file or folder of sources, the package unless others are given. A message is what an error of ``musclewire.errors``
is made with, what a ``ValueError`` of a checked table says, and each text that is added to warnings. ``--list`` prints them
all: owner, file and line, text with the values in braces. Ends with exit code 1 if a message breaks a rule.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "src" / "musclewire"
# Who can do something about it. Errors of other names inherit from one of these, in the file that defines them.
OWNERS = {
    "CallerError": "caller",
    "MissingExtraError": "caller",
    "ValueError": "caller",  # of a table's checks; becomes a CallerError that names file and key
    "RecordingError": "recording",
    "RigError": "rig",
    "NumericsError": "numerics",
}
MIN_SPACES = 3
WRITERS = ("warning", "failure", "problem", "refus", "reason")
MAX_DEPTH = 4  # of names that stand for a text


@dataclass(frozen=True)
class Message:
    """A text that a user may read, with its place; values are names in braces, alternatives stand in angle brackets."""

    owner: str
    path: str
    line: int
    text: str
    warning: bool = False

    def __str__(self) -> str:
        """Return the message as a line."""
        return f"{self.path}:{self.line}: {self.text}"


@dataclass(frozen=True)
class Source:
    """A file of sources, parsed."""

    path: Path

    @cached_property
    def tree(self) -> ast.Module:
        """The syntax tree, in which each node knows the one around it."""
        tree = ast.parse(self.path.read_text("utf-8"))
        for node in ast.walk(tree):
            for child in ast.iter_child_nodes(node):
                child.__dict__["around"] = node
        return tree

    @property
    def name(self) -> str:
        """The path below the repository."""
        return self.path.relative_to(ROOT).as_posix() if self.path.is_relative_to(ROOT) else self.path.as_posix()

    def function_around(self, node: ast.AST) -> ast.AST:
        """Return the innermost function around a node, the file itself if there is none."""
        while (node := node.__dict__.get("around", self.tree)) is not self.tree:
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                return node
        return node

    def values_of(self, name: str, scope: ast.AST) -> list[ast.expr]:
        """Return what is assigned to a name in a function, or else in the file."""
        for place in dict.fromkeys((scope, self.tree)):
            found = [value for node in ast.walk(place) for target, value in assigned(node) if named(target) == name]
            if found:
                return found
        return []


def assigned(node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Yield what an assignment names and what it gives it."""
    if isinstance(node, ast.Assign):
        yield from ((target, node.value) for target in node.targets)
    elif isinstance(node, ast.AnnAssign | ast.NamedExpr | ast.AugAssign) and node.value is not None:
        yield node.target, node.value


def named(node: ast.AST) -> str:
    """Return the last name of an expression, "" if it has none."""
    if isinstance(node, ast.Call):
        return named(node.func)
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


@dataclass(frozen=True)
class Texts:
    """Writes an expression of a source as text."""

    source: Source

    def of(self, node: ast.expr, depth: int = 0) -> str:
        """Return the text of an expression, with values in braces and alternatives in angle brackets."""
        if isinstance(node, ast.Constant):
            return node.value if isinstance(node.value, str) else f"{{{node.value}}}"
        if isinstance(node, ast.JoinedStr):
            return "".join(self.of(part, depth) for part in node.values)
        if isinstance(node, ast.FormattedValue):
            return self.of(node.value, depth)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            return self.of(node.left, depth) + self.of(node.right, depth)
        if isinstance(node, ast.IfExp):
            return choice([self.of(node.body, depth), self.of(node.orelse, depth)])
        if isinstance(node, ast.Name) and depth < MAX_DEPTH:
            return self.of_name(node, depth)
        if isinstance(node, ast.Call) and depth < MAX_DEPTH:
            return self.of_call(node, depth)
        return f"{{{ast.unparse(node)}}}"

    def of_name(self, node: ast.Name, depth: int) -> str:
        """Return the text that a name stands for, the name in braces if it stands for a value."""
        values = self.source.values_of(node.id, self.source.function_around(node))
        texts = [self.of(value, depth + 1) for value in values if is_text(value)]
        return choice(texts) if texts else f"{{{node.id}}}"

    def of_call(self, call: ast.Call, depth: int) -> str:
        """Return what a function of the same file returns, or a text that is filled by ``format``."""
        if named(call) == "format" and isinstance(call.func, ast.Attribute):
            return self.of(call.func.value, depth + 1)
        functions = [node for node in ast.walk(self.source.tree) if isinstance(node, ast.FunctionDef)]
        bodies = [one for one in functions if one.name == named(call)]
        returned = [node.value for one in bodies for node in ast.walk(one) if isinstance(node, ast.Return)]
        texts = [self.of(value, depth + 1) for value in returned if value is not None and is_text(value)]
        return choice(texts) if texts else f"{{{ast.unparse(call)}}}"


def choice(texts: Sequence[str]) -> str:
    """Return alternatives as one text."""
    different = list(dict.fromkeys(texts))
    return different[0] if len(different) == 1 else f"<{'|'.join(different)}>"


def is_text(node: ast.expr) -> bool:
    """Tell whether an expression is written as a text or a choice of texts."""
    if isinstance(node, ast.IfExp):
        return is_text(node.body) or is_text(node.orelse)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return is_text(node.left) or is_text(node.right)
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


@dataclass(frozen=True)
class Finder:
    """Finds the messages of sources; knows the owner of every class of errors, and of what returns an error."""

    owners: dict[str, str]

    @classmethod
    def of(cls, sources: Sequence[Source]) -> Finder:
        """Return a finder that knows the errors that these sources define, and the functions that return one."""
        owners = dict(OWNERS)
        nodes = [node for one in sources for node in ast.walk(one.tree)]
        classes = [node for node in nodes if isinstance(node, ast.ClassDef)]
        for _ in range(MAX_DEPTH):
            heirs = ((one.name, named(base)) for one in classes for base in reversed(one.bases))
            owners = {name: owners[base] for name, base in heirs if base in owners} | owners
        functions = [node for node in nodes if isinstance(node, ast.FunctionDef) and node.returns is not None]
        return cls({one.name: owners[named(one.returns)] for one in functions if named(one.returns) in owners} | owners)

    def messages_in(self, source: Source) -> Iterator[Message]:
        """Yield the messages of a file."""
        texts = Texts(source)
        for node in ast.walk(source.tree):
            if isinstance(node, ast.Call) and named(node) in self.owners:
                said = message_of(node, texts)
                if said is not None:
                    yield Message(self.owners[named(node)], source.name, node.lineno, said)
            elif isinstance(node, ast.expr) and is_warning(node):
                text = texts.of(node)
                if text.count(" ") >= MIN_SPACES:
                    yield Message("warning", source.name, node.lineno, text)


def message_of(call: ast.Call, texts: Texts) -> str | None:
    """Return the text of an error that a call makes, None if it makes none or its text is written elsewhere."""
    error = named(call).endswith("Error")
    if not error and not isinstance(call.__dict__["around"], ast.Raise):
        return None
    found = [texts.of(argument) for argument in call.args]
    written = [text for text in found if " " in text and not text.startswith("{") or "} " in text]
    return written[0] if written else found[0] if found and error else None


def is_warning(node: ast.expr) -> bool:
    """Tell whether a text is added to warnings, or returned by a function whose name says that it writes one."""
    around = node.__dict__["around"]
    if not is_text(node) or (isinstance(around, ast.expr) and is_text(around)) or isinstance(around, ast.FormattedValue):
        return False
    for outer in outwards(node):
        if isinstance(outer, ast.keyword) and outer.arg == "warnings":
            return True
        if isinstance(outer, ast.Call) and (named(outer) == "warn" or "warning" in receiver(outer)):
            return True
        if isinstance(outer, ast.Assign | ast.AnnAssign | ast.AugAssign):
            return any("warning" in named(target) for target, _ in assigned(outer))
        if isinstance(outer, ast.FunctionDef):
            return any(word in outer.name for word in WRITERS)
    return False


def outwards(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what is around a node, the innermost first."""
    while (node := node.__dict__.get("around")) is not None:
        yield node


def receiver(call: ast.Call) -> str:
    """Return the name of the object whose method is called."""
    return named(call.func.value) if isinstance(call.func, ast.Attribute) else ""


def sources_below(places: Sequence[Path]) -> list[Source]:
    """Return the sources in files and folders."""
    paths = [path for place in places for path in (sorted(place.rglob("*.py")) if place.is_dir() else [place])]
    return [Source(path) for path in paths]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what breaks a rule, or everything; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--list", action="store_true", help="print every message")
    parser.add_argument("paths", nargs="*", type=Path, default=[])
    chosen = parser.parse_args(arguments)
    sources = sources_below(chosen.paths or [SOURCES])
    finder = Finder.of(sources_below([SOURCES]))
    messages = sorted((one for source in sources for one in finder.messages_in(source)), key=lambda one: (one.owner, one.path, one.line))
    for one in messages:
        if chosen.list:
            print(f"{one.owner}: {one}")
    count = Counter(one.owner for one in messages)
    print(f"{len(messages)} messages: " + ", ".join(f"{number} {owner}" for owner, number in sorted(count.items())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
