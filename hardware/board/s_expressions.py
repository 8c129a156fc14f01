"""Read and write KiCad's files: nested lists of words, quoted text kept apart from bare words."""

from __future__ import annotations

import re
from pathlib import Path

__all__ = ["Quoted", "Tree", "children", "first", "load", "read_tree", "written"]

TOKEN = re.compile(r'\s*(?:(\()|(\))|"((?:[^"\\]|\\.)*)"|([^\s()"]+))')


class Quoted(str):
    """Text that stands in quotation marks."""

    __slots__ = ()


Tree = list["str | Tree"]


def read_tree(text: str) -> Tree:
    """Return the one expression of a text. Raises ValueError if brackets are left open."""
    stack: list[Tree] = [[]]
    for token in TOKEN.finditer(text):
        opening, closing, quoted, bare = token.groups()
        if opening:
            stack.append([])
        elif closing:
            done = stack.pop()
            stack[-1].append(done)
        else:
            stack[-1].append(Quoted(re.sub(r"\\(.)", r"\1", quoted)) if bare is None else bare)
    (tree,) = stack.pop() if len(stack) == 1 else [None]
    if not isinstance(tree, list):
        raise ValueError("the brackets of this file do not close")
    return tree


def children(tree: Tree, name: str) -> list[Tree]:
    """Return the lists in a list that begin with a name."""
    return [item for item in tree if isinstance(item, list) and item and item[0] == name]


def first(tree: Tree, name: str) -> Tree:
    """Return the first list that begins with a name. Raises KeyError without one."""
    for item in children(tree, name):
        return item
    raise KeyError(f"there is no '{name}' in '{tree[0]}'")


def written(tree: str | Tree, depth: int = 0) -> str:
    """Return an expression as text, a line for each list."""
    if isinstance(tree, list):
        inner = " ".join(written(item, depth + 1) for item in tree)
        return ("\n" + "\t" * depth if depth else "") + f"({inner})"
    if isinstance(tree, Quoted):
        return '"' + tree.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
    return tree


def load(path: Path) -> Tree:
    """Return the expression in a file."""
    return read_tree(path.read_text("utf-8"))
