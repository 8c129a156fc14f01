"""A page for every public name, from its docstring: what a script imports from the package and from its rooms."""

from __future__ import annotations

import importlib
import inspect
import re
import sys
from pathlib import Path
from typing import Any

import musclewire

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "images"))
import python_page
from layout import toctree

# Settings of pydantic's classes, which are no part of what a reader calls.
NO_MEMBERS = "model_config, model_post_init"
# A row of the table of names on the page on Python.
ROW = re.compile(r"^\| (`(?:mw\.)?(\w+)[^`]*`) \|", re.M)


def public_names() -> dict[str, dict[str, Any]]:
    """Return every public name with its object, by the module that a script imports it from."""
    own = {name: getattr(musclewire, name) for name in musclewire.__all__}
    modules = {"musclewire": own}
    for room in python_page.ROOMS:
        module = importlib.import_module(f"musclewire.{room}")
        modules[module.__name__] = {name: getattr(module, name) for name in module.__all__ if name not in own}
    return modules


def write_api_pages(reference: Path) -> None:
    """Write the pages into the folder api/ of the reference, and lead to them from the page on Python."""
    folder = reference / "api"
    folder.mkdir()
    modules = public_names()
    for module, items in modules.items():
        write_module(folder, module, items)
    python = reference / "python.md"
    pages = {name: f"{module}.{name}" for module, items in modules.items() for name in items}
    text = ROW.sub(
        lambda row: f"| [{row[1]}](api/{pages[row[2]]}.rst) |" if row[2] in pages else row[0], python.read_text("utf-8")
    )
    python.write_text(f"{text}\n{toctree([f'api/{module}' for module in modules], '')}", encoding="utf-8")


def write_module(folder: Path, module: str, items: dict[str, Any]) -> None:
    """Write the page of a module and, under it, those of its names."""
    pages = [write_name(folder, module, name, item) for name, item in items.items()]
    summary = "What a script imports first." if module == "musclewire" else first_line(importlib.import_module(module))
    rows = []
    for (name, item), page in zip(items.items(), pages, strict=True):
        rows += [f"   * - :doc:`{name} <{page}>`", f"     - {summary_of(name, item)}"]
    table = [".. list-table::", "   :widths: 30 70", "", *rows]
    tree = [".. toctree::", "   :hidden:", "", *(f"   {page}" for page in pages)]
    text = "\n".join([module, "=" * len(module), "", summary, "", *table, "", *tree, ""])
    (folder / f"{module}.rst").write_text(text, encoding="utf-8")


def write_name(folder: Path, module: str, name: str, item: Any) -> str:
    """Write the page of a name, and return what it is called without its suffix."""
    full = f"{module}.{name}"
    body = [f".. py:data:: {full}", "", f"   {summary_of(name, item)}", ""]
    if inspect.isclass(item):
        body = [f".. autoclass:: {full}", "   :members:", f"   :exclude-members: {NO_MEMBERS}", ""]
    elif inspect.isfunction(inspect.unwrap(item)):
        body = [f".. autofunction:: {full}", ""]
    (folder / f"{full}.rst").write_text("\n".join([name, "=" * len(name), "", *body]), encoding="utf-8")
    return full


def summary_of(name: str, item: Any) -> str:
    """Return what a name is in one line of reStructuredText."""
    line = python_page.OTHERS.get(name) or python_page.first_line(item)
    return line.replace(" ([files](files.md))", "").replace("`", "``")


def first_line(module: Any) -> str:
    """Return the first sentence of a module's docstring in reStructuredText."""
    return python_page.first_line(module).replace("`", "``")
