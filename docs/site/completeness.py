"""What the built site must have: every public name, key and column, and no link that leads nowhere."""

from __future__ import annotations

import os
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import rig_keys_page
import toml_keys_page
from api_pages import public_names
from pydantic import BaseModel

from musclewire.rigs import DEVICES, LOAD_PARTS, RigConfiguration, Surroundings
from musclewire.sensing import ModelFile
from musclewire.signals import COLUMNS

# Attributes by which a page asks for something.
ASKS = {"a": "href", "link": "href", "img": "src", "script": "src", "source": "src", "object": "data", "iframe": "src"}
# Of these a page of the site may name what is elsewhere: nothing is fetched until the reader follows it.
LINKS_ONLY = ("a",)


class Page(HTMLParser):
    """A page of the site: its anchors, what it asks for, and its texts in code."""

    def __init__(self, text: str) -> None:
        """Read the page."""
        super().__init__()
        self.anchors: set[str] = set()
        self.asked: list[tuple[str, str]] = []
        self.code: set[str] = set()
        self._open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an anchor and what an element asks for."""
        found = dict(attrs)
        if found.get("id"):
            self.anchors.add(str(found["id"]))
        if found.get(ASKS.get(tag, "")):
            self.asked.append((tag, str(found[ASKS[tag]])))
        if tag == "code":
            self._open.append("")

    def handle_data(self, data: str) -> None:
        """Note a text in code."""
        self._open = [text + data for text in self._open]

    def handle_endtag(self, tag: str) -> None:
        """Note the end of code."""
        if tag == "code" and self._open:
            self.code.add(" ".join(self._open.pop().split()))


def missing(site: Path) -> Iterator[str]:
    """Yield a line for everything that the site must have and does not."""
    pages = {path: Page(path.read_text("utf-8")) for path in sorted(site.rglob("*.html"))}
    yield from names_without_page(pages, site)
    reference = {path.name: page.code for path, page in pages.items() if path.parent == site / "reference"}
    yield from (f"column not in reference/columns: {name}" for name in set(COLUMNS) - reference["columns.html"])
    keys = reference["files.html"] | reference["rig_files.html"] | reference["toml_files.html"]
    yield from (f"key not in reference/files, rig_files or toml_files: {key}" for key in toml_keys() - keys)
    yield from broken_links(pages, site)


def names_without_page(pages: dict[Path, Page], site: Path) -> Iterator[str]:
    """Yield every public name that is not documented on a page of its own."""
    for name in public_names():
        path = site / "reference" / "api" / f"{name}.html"
        if path not in pages or name not in pages[path].anchors:
            yield f"public name without its page: {name}"


def toml_keys() -> set[str]:
    """Return every key of rig files, of the parts of a load, of every kind of device, of models and of all other files.

    ``part`` names the kind of a part, of which each has its rows.
    """
    schemas: list[type[BaseModel]] = [RigConfiguration, ModelFile, Surroundings]
    schemas += [LOAD_PARTS.find(name) for name in LOAD_PARTS.own_names()]
    schemas += [DEVICES.find(name).configuration for name in DEVICES.own_names()]
    schemas += [model for model, _ in [*rig_keys_page.SECTIONS.values(), *rig_keys_page.SIMULATED.values()]]
    schemas += [model for model, _ in toml_keys_page.SECTIONS.values()]
    return {key for schema in schemas for key in schema.model_fields} - {"part"}


def broken_links(pages: dict[Path, Page], site: Path) -> Iterator[str]:
    """Yield every local link, anchor, picture or script that leads nowhere, and what a network would be needed for."""
    files: dict[str, Path] = {}  # the navigation asks for the same ones on every page
    for path, page in pages.items():
        for tag, target in dict.fromkeys(page.asked):
            where = f"{path.relative_to(site)}: {target}"
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                if tag not in LINKS_ONLY and parts.scheme != "data":
                    yield f"fetched from a network by {where}"
                continue
            asked = os.path.normpath(f"{path.parent}/{unquote(parts.path)}") if parts.path else str(path)
            if asked not in files:
                file = Path(asked)
                files[asked] = file / "index.html" if file.is_dir() else file
                if not files[asked].exists():
                    yield f"leads nowhere: {where}"
            file = files[asked]
            if parts.fragment and file in pages and unquote(parts.fragment) not in pages[file].anchors:
                yield f"anchor that is not there: {where}"
