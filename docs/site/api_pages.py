"""A page for every promised name, from its docstring: what a script imports from the package."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "images"))
import python_page
from layout import toctree

PACKAGE = "musclewire"
# Settings of pydantic's classes, which are no part of what a reader calls.
NO_MEMBERS = "model_config, model_post_init"
# A row of the table of names on the page on Python.
ROW = re.compile(r"^\| (`(?:mw|musclewire\.compiled)\.(\w+)[^`]*`) \|", re.M)
# A link at the end of a summary, which is written for the page in Markdown.
LINK_OF_MARKDOWN = re.compile(r" \(\[[^\]]*\]\([^)]*\)\)")


def public_names() -> dict[str, Any]:
    """Return every promised name, as it is imported, with its object."""
    found = {f"{PACKAGE}.{name}": item for items in python_page.sections().values() for name, item in items.items()}
    return found | python_page.decorator()


def write_api_pages(reference: Path) -> None:
    """Write the pages into the folder api/ of the reference, and lead to them from the page on Python."""
    folder = reference / "api"
    folder.mkdir()
    names = public_names()
    for full, item in names.items():
        write_name(folder, full, item)
    write_package(folder)
    python = reference / "python.md"
    pages = {full.rpartition(".")[2]: full for full in names}
    text = ROW.sub(lambda row: f"| [{row[1]}](api/{pages[row[2]]}.rst) |", python.read_text("utf-8"))
    python.write_text(f"{text}\n{toctree([f'api/{PACKAGE}'], '')}", encoding="utf-8")


def write_package(folder: Path) -> None:
    """Write the page of the package: its names in the sections of the page on Python, each leading to its page."""
    lines = [PACKAGE, "=" * len(PACKAGE), "", "All names that are promised; nothing is loaded until one is used.", ""]
    for heading, items in python_page.sections().items():
        title = heading.replace("`", "")
        lines += [title, "-" * len(title), "", *rows_of({f"{PACKAGE}.{name}": item for name, item in items.items()})]
    title = "Compiled"
    lines += [title, "-" * len(title), "", *rows_of(python_page.decorator())]
    (folder / f"{PACKAGE}.rst").write_text("\n".join(lines), encoding="utf-8")


def rows_of(items: dict[str, Any]) -> list[str]:
    """Return the lines of a table of names, each leading to its page."""
    rows = [".. list-table::", "   :widths: 30 70", ""]
    for full, item in items.items():
        name = full.rpartition(".")[2]
        rows += [f"   * - :doc:`{name} <{full}>`", f"     - {summary_of(name, item)}"]
    return [*rows, ""]


def write_name(folder: Path, full: str, item: Any) -> None:
    """Write the page of a name; in the navigation, which every page repeats, the package stands for all names."""
    name = full.rpartition(".")[2]
    body = [f".. py:data:: {full}", "", f"   {summary_of(name, item)}", ""]
    if inspect.isclass(item):
        body = [f".. autoclass:: {full}", "   :members:", f"   :exclude-members: {NO_MEMBERS}", ""]
    elif inspect.isfunction(inspect.unwrap(item)):
        body = [f".. autofunction:: {full}", ""]
    (folder / f"{full}.rst").write_text("\n".join([":orphan:", "", name, "=" * len(name), "", *body]), encoding="utf-8")


def summary_of(name: str, item: Any) -> str:
    """Return what a name is in one line of reStructuredText."""
    line = python_page.OTHERS.get(name) or python_page.first_line(item)
    return LINK_OF_MARKDOWN.sub("", line).replace("`", "``")
