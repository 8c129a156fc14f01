"""Find words that an engineer of the field would stumble on, in sentences and in names, by the list in words.toml.

    python checks/words.py [PATH ...]

PATH is the documentation, the sources and the project's pages unless others are given. Each finding is a line: place,
word, what to write instead. Exit code 1 if there is one. (Vale does this for sentences of pages, but its packages
download the program when it is first run, and it reads no names.)
"""

from __future__ import annotations

import ast
import io
import re
import sys
import tokenize
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PLACES = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "docs", "packages", "src")
SUFFIXES = {".css", ".html", ".js", ".md", ".py", ".toml"}
OF_OTHERS = "vendor"  # a folder of files that come from elsewhere, unchanged
CODE_IN_TEXT = re.compile(r"^```.*?^```|^ {4}.*?$|`[^`\n]*`|\]\([^)]*\)", re.M | re.S)
CODE_IN_COMMENTS = re.compile(r"`[^`\n]*`|\]\([^)]*\)")


class Word(NamedTuple):
    """A word of the list: how to find it, what to write instead, in which company and in which files it is right."""

    find: re.Pattern[str]
    instead: str
    right: tuple[re.Pattern[str], ...]
    files: tuple[str, ...]

    def found_in(self, text: str) -> Iterator[re.Match[str]]:
        """Yield each place where the word is and is not right."""
        for match in self.find.finditer(text):
            around = (other for pattern in self.right for other in pattern.finditer(text))
            if not any(other.start() <= match.end() and match.start() <= other.end() for other in around):
                yield match


def word_list(kind: str, flags: int) -> list[Word]:
    """Return the words of one kind in the list."""
    entries = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))[kind]
    return [
        Word(
            re.compile(entry["find"], flags),
            entry["instead"],
            tuple(re.compile(text, flags) for text in entry.get("right", ())),
            tuple(entry.get("files", ())),
        )
        for entry in entries
    ]


PROSE, NAMES = word_list("prose", re.IGNORECASE), word_list("name", 0)


def findings_in(path: Path) -> Iterator[str]:
    """Yield the findings in a file, each with its place and what to write instead."""
    text = path.read_text("utf-8")
    name = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.as_posix()
    parts = [(PROSE, line, part) for line, part in sentences_in(path, text)]
    if path.suffix == ".py":
        parts += [(NAMES, line, identifier) for line, identifier in sorted(set(names_in(text)))]
    for words, line, part in parts:
        for word in words:
            for match in word.found_in(part) if name not in word.files else ():
                place = line + part.count("\n", 0, match.start())
                yield f"{name}:{place}: '{' '.join(match[0].split())}': {word.instead}"


def sentences_in(path: Path, text: str) -> Iterator[tuple[int, str]]:
    """Yield the parts of a file that people read, each with its first line, without code in them."""
    if path.suffix == ".md":
        line = 1
        for part in re.split(r"(\n\s*\n)", CODE_IN_TEXT.sub(lambda code: "`" + "\n" * code[0].count("\n"), text)):
            yield line, part
            line += part.count("\n")
    elif path.suffix == ".py":
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type == tokenize.COMMENT:
                yield token.start[0], CODE_IN_COMMENTS.sub("`", token.string)
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
                yield node.lineno, CODE_IN_COMMENTS.sub("`", node.value)
    else:
        yield from enumerate(text.splitlines(), 1)


def names_in(source: str) -> Iterator[tuple[int, str]]:
    """Yield the names that a Python file defines: functions, classes, parameters, variables, fields."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, (ast.Name, ast.Attribute)) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id if isinstance(node, ast.Name) else node.attr


def main() -> int:
    """Print the findings and return the exit code."""
    found = 0
    for place in map(Path, sys.argv[1:] or [ROOT / place for place in PLACES]):
        for file in sorted(place.rglob("*")) if place.is_dir() else [place]:
            if file.suffix in SUFFIXES and OF_OTHERS not in file.parts:
                for finding in findings_in(file.resolve()):
                    print(finding)
                    found += 1
    print(f"{found} words to replace")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
