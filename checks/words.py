"""Find words that an engineer of the field would stumble on, in sentences and in names, by the list in words.toml.

    python checks/words.py [--waiting] [PATH ...]

PATH is the documentation, the sources and the project's pages unless others are given. Each finding is a line: place,
word, what to write instead. ``--waiting`` counts the findings in the rooms that words.toml still lists as waiting. Ends
with exit code 1 if there is a finding outside of these, or none in one of them.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import sys
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
LIST = Path(__file__).with_suffix(".toml")
PLACES = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "docs", "src")
SUFFIXES = {".css", ".html", ".js", ".md", ".py", ".toml"}
OF_OTHERS = "vendor"  # a folder of files that come from elsewhere, unchanged
CODE_IN_TEXT = re.compile(r"`[^`\n]*`|\]\([^)]*\)")


@dataclass(frozen=True)
class Word:
    """A word of the list: how to find it, what to write instead, and in which company it is right."""

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


@dataclass(frozen=True)
class Finding:
    """A word at a line of a file."""

    path: str
    line: int
    text: str
    instead: str

    def __str__(self) -> str:
        """Return the finding as a line."""
        return f"{self.path}:{self.line}: '{self.text}': {self.instead}"


@dataclass(frozen=True)
class WordList:
    """The words of sentences and of names, and the paths whose turn is yet to come."""

    prose: tuple[Word, ...]
    names: tuple[Word, ...]
    waiting: tuple[str, ...]


def read_list(path: Path = LIST) -> WordList:
    """Return the list in a file."""
    data = tomllib.loads(path.read_text("utf-8"))
    prose = tuple(word_from(entry, re.IGNORECASE) for entry in data.get("prose", ()))
    names = tuple(word_from(entry, 0) for entry in data.get("name", ()))
    return WordList(prose, names, tuple(data.get("waiting", {}).get("paths", ())))


def word_from(entry: dict[str, Any], flags: int) -> Word:
    """Return a word from its table."""
    right = tuple(re.compile(text, flags) for text in entry.get("right", ()))
    return Word(re.compile(entry["find"], flags), entry["instead"], right, tuple(entry.get("files", ())))


def findings_in(path: Path, words: WordList) -> Iterator[Finding]:
    """Yield the findings in a file."""
    text = path.read_text("utf-8")
    name = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.as_posix()
    for line, sentence in sentences_in(path, text):
        yield from matches(words.prose, name, line, sentence)
    if path.suffix == ".py":
        for line, identifier in sorted(set(names_in(text))):
            yield from matches(words.names, name, line, identifier)


def matches(words: Sequence[Word], path: str, line: int, text: str) -> Iterator[Finding]:
    """Yield the words of a list that a text has; ``line`` is that of its first character."""
    for word in words:
        if path in word.files:
            continue
        for match in word.found_in(text):
            place = line + text.count("\n", 0, match.start())
            yield Finding(path, place, " ".join(match[0].split()), word.instead)


def sentences_in(path: Path, text: str) -> Iterator[tuple[int, str]]:
    """Yield the parts of a file that people read, each with its first line."""
    if path.suffix == ".md":
        yield from paragraphs(text)
    elif path.suffix == ".py":
        yield from strings_and_comments(text)
    else:
        yield from enumerate(text.splitlines(), 1)


def paragraphs(text: str) -> Iterator[tuple[int, str]]:
    """Yield the paragraphs of a page, without code."""
    lines, start, fenced = [], 1, False
    for number, line in enumerate([*text.splitlines(), ""], 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        if fenced or not line.strip() or line.startswith(("```", "    ")):
            if lines:
                yield start, "\n".join(lines)
            lines, start = [], number + 1
        else:
            lines.append(CODE_IN_TEXT.sub("`", line))


def strings_and_comments(source: str) -> Iterator[tuple[int, str]]:
    """Yield comments, docstrings and texts of a Python file, without code in them."""
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], CODE_IN_TEXT.sub("`", token.string)
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield node.lineno, CODE_IN_TEXT.sub("`", node.value)


def names_in(source: str) -> Iterator[tuple[int, str]]:
    """Yield the names that a Python file defines: functions, classes, parameters, variables, fields."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.attr


def files_below(places: Sequence[str | Path]) -> list[Path]:
    """Return the files to read, each once."""
    found: list[Path] = []
    for place in map(Path, places):
        path = place if place.is_absolute() else ROOT / place
        inside = sorted(path.rglob("*")) if path.is_dir() else [path]
        found += [file for file in inside if file.suffix in SUFFIXES and OF_OTHERS not in file.parts]
    return list(dict.fromkeys(found))


def waiting_place(finding: Finding, words: WordList) -> str | None:
    """Return the waiting path that a finding is below, None if it is below none."""
    below = (path for path in words.waiting if finding.path == path or finding.path.startswith(f"{path}/"))
    return next(below, None)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the findings and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--waiting", action="store_true", help="count the findings in waiting rooms by word")
    parser.add_argument("paths", nargs="*", default=[])
    chosen = parser.parse_args(arguments)
    words = read_list()
    findings = [one for path in files_below(chosen.paths or PLACES) for one in findings_in(path, words)]
    wrong = [one for one in findings if waiting_place(one, words) is None]
    waiting = Counter((str(waiting_place(one, words)), one.instead) for one in findings if one not in wrong)
    for one in wrong:
        print(one)
    if chosen.waiting:
        for (place, instead), count in sorted(waiting.items(), key=lambda item: (item[0][0], -item[1])):
            print(f"{count:5} {place}: {instead}")
    empty = [] if chosen.paths else [place for place in words.waiting if place not in {key[0] for key in waiting}]
    for place in empty:
        print(f"checks/words.toml: nothing is found in {place} any more: take it out of the waiting paths")
    print(f"{len(wrong)} words to replace; {sum(waiting.values())} more in {len(words.waiting)} waiting rooms")
    return 1 if wrong or empty else 0


if __name__ == "__main__":
    sys.exit(main())
