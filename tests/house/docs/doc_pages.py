"""Helpers for the tests that hold the documentation to the code."""

from __future__ import annotations

import importlib
import re
from typing import Any


def tables_of(text: str) -> list[list[dict[str, str]]]:
    """Every table of a Markdown page as rows of header -> cell."""
    tables: list[list[dict[str, str]]] = []
    header: list[str] | None = None
    for line in text.splitlines():
        if not line.startswith("|"):
            header = None
            continue
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]
        if header is None:
            header = cells
            tables.append([])
        elif not set("".join(cells)) <= set("-: "):
            assert len(cells) == len(header), f"{len(cells)} cells under {len(header)} headers: {line}"
            tables[-1].append(dict(zip(header, cells, strict=True)))
    return tables


def anchors_of(text: str) -> list[str]:
    """Return the anchors of a Markdown page's headings, as GitHub makes them."""
    text = re.sub(r"^(```+|~~~+).*?^\1", "", text, flags=re.M | re.S)
    found: list[str] = []
    for heading in re.findall(r"^#{1,6} (.+?)\s*$", text, re.M):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        anchor = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        found.append(f"{anchor}-{again}" if (again := sum(one == anchor for one in found)) else anchor)
    return found


def code_words(cell: str) -> list[str]:
    """Return the texts between backticks in a cell."""
    return re.findall(r"`([^`]+)`", cell)


def resolve(name: str) -> Any:
    """The object that ``module:object`` names, musclewire's own name left out; fields count as objects."""
    module, _, path = name.partition(":")
    found = importlib.import_module(module if module.startswith("musclewire_") else f"musclewire.{module}")
    for part in path.split("."):
        fields = {**getattr(found, "model_fields", {}), **getattr(found, "__annotations__", {})}
        found = getattr(found, part) if hasattr(found, part) else fields[part]
    return found
