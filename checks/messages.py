"""List every message of an error or a warning in the source, by owner, and hold each to rules.

    python -m checks.messages [--list] [PATH ...]

PATH is a file or folder of sources, the package unless others are given. A message is what an error is made with, or a
text that is added to warnings, or returned by a function named for a warning, a problem or a refusal. ``--list`` prints
each with owner, file and line; values are in braces, alternatives in angle brackets. Ends with exit code 1 if a message
breaks a rule: it says in one line what is wrong, where, and what to do.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SHARED = (ast.expr_context, ast.operator, ast.unaryop, ast.boolop, ast.cmpop)
SOURCES = ROOT / "src" / "musclewire"
LIST = Path(__file__).with_suffix(".toml")
# Who can do something about it. Errors of other names inherit from one of these, in the file that defines them.
OWNERS = {
    "CallerError": "caller",
    "MissingExtraError": "caller",
    "ValueError": "caller",  # of a table's checks; becomes a CallerError that names file and key
    "RecordingError": "recording",
    "RigError": "rig",
    "NumericsError": "numerics",
}
WRITERS = ("warning", "failure", "problem", "refus", "reason")  # in names of functions that return a message
# What an error adds to the text that it is made with, where it is made or where it is caught.
ENDS = {
    "MissingExtraError": " needs the extra {extra}: install it",
    "BoardFaultError": "; {remedy}",
    "LinkStormError": "; {remedy}",
    "_UnitError": "; write it like {example}",
}
PAGES = ("/app/_report/", "/extras/paper/_page/")  # what is written there is read on a page, among what it explains
MIN_SPACES = 3  # of a text that a function returns, to be a sentence
MAX_DEPTH = 4  # of names that stand for a text, and of classes between an error and its owner
MAX_WORDS = 75
VALUE = re.compile(r"\{[^{}]*\}")
BEGINS = re.compile(r"[^A-Z]|(NI|MATLAB|FMI|Recording|LiveClient)\b")


@dataclass(frozen=True)
class Message:
    """A text that a user may read, with its place; values are names in braces, alternatives stand in angle brackets."""

    owner: str
    path: str
    line: int
    text: str

    def __str__(self) -> str:
        """Return the message as a line."""
        return f"{self.owner}: {self.path}:{self.line}: {self.text}"


@dataclass(frozen=True)
class Source:
    """A file of sources, parsed."""

    path: Path

    @cached_property
    def tree(self) -> ast.Module:
        """The syntax tree, in which each node knows the one around it."""
        tree = ast.parse(self.path.read_text("utf-8"))
        for node in ast.walk(tree):
            # Loads, stores and operators are one object each for every tree of the process: they get no note.
            for child in ast.iter_child_nodes(node):
                if not isinstance(child, SHARED):
                    child.__dict__["around"] = node
        return tree

    @property
    def name(self) -> str:
        """The path below the repository."""
        return self.path.relative_to(ROOT).as_posix() if self.path.is_relative_to(ROOT) else self.path.as_posix()

    def scope_of(self, node: ast.AST) -> ast.AST:
        """Return the innermost function or class around a node, the file itself if there is none."""
        scopes = (one for one in outwards(node) if isinstance(one, ast.FunctionDef | ast.ClassDef))
        return next(scopes, self.tree)

    def values_of(self, name: str, scope: ast.AST) -> list[ast.expr]:
        """Return what is assigned to a name in a function, or else in the file."""
        of_name = self.assignments.get(name, [])
        here = [value for value in of_name if self.scope_of(value) is scope]
        return here or [value for value in of_name if self.scope_of(value) is self.tree]

    @cached_property
    def assignments(self) -> dict[str, list[ast.expr]]:
        """What is assigned to each name of the file."""
        found: dict[str, list[ast.expr]] = {}
        for node in ast.walk(self.tree):
            for target, value in assigned(node):
                found.setdefault(named(target), []).append(value)
        return found

    @cached_property
    def returned(self) -> dict[str, list[ast.expr]]:
        """What each function of the file returns."""
        functions = [node for node in ast.walk(self.tree) if isinstance(node, ast.FunctionDef)]
        return {
            one.name: [node.value for node in ast.walk(one) if isinstance(node, ast.Return) and node.value is not None]
            for one in functions
        }


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
        values = self.source.values_of(node.id, self.source.scope_of(node))
        texts = [self.of(value, depth + 1) if is_text(value) else f"{{{node.id}}}" for value in values]
        return choice(texts) if any(is_text(value) for value in values) else f"{{{node.id}}}"

    def of_call(self, call: ast.Call, depth: int) -> str:
        """Return what a function of the same file returns, or a text that is filled by ``format``."""
        if named(call) == "format" and isinstance(call.func, ast.Attribute):
            return self.of(call.func.value, depth + 1)
        texts = [self.of(value, depth + 1) for value in self.source.returned.get(named(call), []) if is_text(value)]
        said = choice(texts) if texts else ""
        return said if " " in VALUE.sub("", said) else f"{{{ast.unparse(call)}}}"


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
            elif isinstance(node, ast.expr) and not any(folder in source.name for folder in PAGES) and is_warning(node):
                text = texts.of(node)
                if text.count(" ") >= MIN_SPACES:
                    yield Message("warning", source.name, node.lineno, text)


def message_of(call: ast.Call, texts: Texts) -> str | None:
    """Return the text of an error that a call makes, None if it makes none or its text is written elsewhere."""
    found = [texts.of(argument) for argument in call.args]
    written = [text for text in found if " " in VALUE.sub("", text).strip()]
    if named(call) in ENDS:
        return f"{(written or found)[0]}{ENDS[named(call)]}"
    if named(call).endswith("Error"):
        return (written or found or [None])[0]
    # What returns an error and takes one text puts the place in front of it.
    placed = isinstance(around(call), ast.Raise) and len(found) == len(written) == 1
    return f"{{place}}: {written[0]}" if placed else None


def is_warning(node: ast.expr) -> bool:
    """Tell whether a text is added to warnings, or returned by a function whose name says that it writes one."""
    outside = around(node)
    part = isinstance(outside, ast.FormattedValue | ast.Expr) or (isinstance(outside, ast.expr) and is_text(outside))
    if part or not is_text(node):
        return False
    for outer in outwards(node):
        if isinstance(outer, ast.Raise | ast.Compare):
            return False
        if isinstance(outer, ast.keyword) and outer.arg == "warnings":
            return True
        if isinstance(outer, ast.Call) and (named(outer) == "warn" or "warning" in receiver(outer)):
            return True
        if isinstance(outer, ast.Assign | ast.AnnAssign | ast.AugAssign):
            return any("warning" in named(target) for target, _ in assigned(outer))
        if isinstance(outer, ast.FunctionDef):
            return any(word in outer.name for word in WRITERS)
    return False


def around(node: ast.AST) -> ast.AST | None:
    """Return what is directly around a node."""
    found: ast.AST | None = node.__dict__.get("around")
    return found


def outwards(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what is around a node, the innermost first."""
    outer = around(node)
    while outer is not None:
        yield outer
        outer = around(outer)


def receiver(call: ast.Call) -> str:
    """Return the name of the object whose method is called."""
    return named(call.func.value) if isinstance(call.func, ast.Attribute) else ""


@dataclass(frozen=True)
class Rules:
    """What a message must have, and must not have."""

    avoid: tuple[tuple[re.Pattern[str], str], ...]
    about: re.Pattern[str]
    reviewed: re.Pattern[str]
    cure: re.Pattern[str]
    passed_on: re.Pattern[str]

    @classmethod
    def read(cls, path: Path = LIST) -> Rules:
        """Return the rules in a file."""
        data = tomllib.loads(path.read_text("utf-8"))
        about, cure = data["about"], data["cure"]
        words = "|".join(f"{cure['verbs']} {cure['demands']}".split())
        return cls(
            tuple((re.compile(one["find"], re.IGNORECASE), one["reason"]) for one in data["avoid"]),
            re.compile(about["find"]),
            re.compile("|".join(about["right"])),
            re.compile(rf"\b({words})\b|\?|hint\b|nearest_|known: |it has |is missing|musclewire [a-z]+ "),
            re.compile(rf"(?i)\{{[^{{}}]*({'|'.join(cure['passed_on'].split())})[^{{}}]*\}}"),
        )

    def broken_by(self, message: Message) -> Iterator[str]:
        """Yield what is wrong with a message; one that only passes another text on is judged where that is written."""
        text = message.text
        fixed = VALUE.sub("", text)
        if not re.search(r"\w{2}", fixed):
            return
        yield from (reason for pattern, reason in self.avoid if pattern.search(text))
        if not BEGINS.match(text.lstrip("<")):
            yield "begin with a small letter: the line follows 'error:' or a place"
        if not (self.about.search(text) or self.reviewed.match(text)):
            yield "name the value, the option or the key"
        if re.search(r"\bmust\b", fixed) and "{" not in text:
            yield "say what was given next to what must be"
        if not self.cure.search(fixed) and not self.passed_on.search(text):
            yield "say what to do"
        if len(VALUE.sub("x", text).split()) > MAX_WORDS:
            yield f"use fewer than {MAX_WORDS} words"


def sources_below(places: Sequence[Path]) -> list[Source]:
    """Return the sources in files and folders."""
    paths = [path for place in places for path in (sorted(place.rglob("*.py")) if place.is_dir() else [place])]
    return [Source(path) for path in paths]


def messages_below(places: Sequence[Path] = (SOURCES,)) -> list[Message]:
    """Return the messages in files and folders, by owner and place."""
    known = sources_below([SOURCES])
    finder, paths = Finder.of(known), {one.path: one for one in known}
    sources = [paths.get(one.path, one) for one in sources_below(places)]
    found = (one for source in sources for one in finder.messages_in(source))
    return sorted(found, key=lambda one: (one.owner, one.path, one.line))


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what breaks a rule, or every message; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--list", action="store_true", help="print every message")
    parser.add_argument("paths", nargs="*", type=Path, default=[])
    chosen = parser.parse_args(arguments)
    rules, messages = Rules.read(), messages_below([path.resolve() for path in chosen.paths] or [SOURCES])
    broken = [(one, reason) for one in messages for reason in rules.broken_by(one)]
    if chosen.list:
        print(*messages, sep="\n")
    for one, reason in broken:
        print(f"{one}\n    {reason}")
    count = Counter(one.owner for one in messages)
    print(f"{len(messages)} messages: " + ", ".join(f"{number} {owner}" for owner, number in sorted(count.items())))
    print(f"{len(broken)} rules broken")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
