"""The sources of the site: pages of docs/ and of the project, and those that are written here, with what Sphinx needs.

docs/README.md is the first page, and its headings are the navigation: a second-level heading is a part, a third-level
one a group with a page of its own, and each link in a list is a page.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

# Pages outside of docs/, which the site has in its folder project/; other pages there are files to download.
PROJECT_PAGES = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md")
# Folders of docs/ that are no pages: this one, what draws pictures, and decisions' place below.
NO_PAGES = ("site",)
DECISIONS = "explanation/decisions"
LINK = re.compile(r"(!?\[[^\]]*\])\(([^)\s#]+)(#[^)\s]*)?\)")
FENCED = re.compile(r"^(`{3,})[^\n]*\n.*?^\1\s*$|`[^`\n]+`", re.M | re.S)
MERMAID = re.compile(r"^```mermaid\n(.*?)^```$", re.M | re.S)
HEADING = re.compile(r"^(#{2,3}) (.+)$", re.M)
# The page that has a heading for each page in no commit, and below it one for each place there that a page links to.
GENERATED = "reference/generated.md"
SAID_OF_PAGE = re.compile(r"^## (\w+)\n\n`[^`]+`: (.+)$", re.M)
LISTED = re.compile(r"\]\(([\w./-]+\.(?:md|ipynb))\)")


def lay_out(root: Path, sources: Path, written: Mapping[str, str]) -> None:
    """Write the sources of the site into a folder; ``written`` are the pages that are in no commit, by name."""
    docs = root / "docs"
    shutil.copytree(docs, sources, ignore=shutil.ignore_patterns("__pycache__", ".ipynb_checkpoints", *NO_PAGES))
    (sources / "README.md").rename(sources / "index.md")
    (sources / "project").mkdir()
    for name in PROJECT_PAGES:
        shutil.copy(root / name, sources / "project" / name)
    for name, text in written.items():
        (sources / f"{name}.md").write_text(text, encoding="utf-8")
    titles = {name: text.partition("\n")[0].removeprefix("# ") for name, text in written.items()}
    generated = sources / GENERATED
    places = places_of(generated.read_text("utf-8"))
    generated.write_text(listed_pages(generated.read_text("utf-8"), titles, docs), encoding="utf-8")
    for page in sorted([*sources.rglob("*.md"), *sources.rglob("*.ipynb")]):
        path = page.relative_to(sources).as_posix()
        origin = origin_of(path, root)
        text = page.read_text("utf-8")
        if path.startswith(f"{DECISIONS}/"):
            text = f"---\nnosearch: true\n---\n\n{text}"
        text = MERMAID.sub(lambda found: transitions_as_table(found[1]), text)
        text = relinked(text, origin, page, root, sources)
        page.write_text(to_written_pages(text, page, sources, places, titles), encoding="utf-8")
    add_navigation(sources)


def origin_of(path: str, root: Path) -> Path:
    """Return the file in the repository that a page of the site is made of."""
    if path.startswith("project/"):
        return root / path.removeprefix("project/")
    return root / "docs" / ("README.md" if path == "index.md" else path)


def place_of(file: Path, root: Path, sources: Path) -> Path | None:
    """Return where the site has a file of the repository; None if it has it as a file to download or not at all."""
    docs = root / "docs"
    if file == docs / "README.md":
        return sources / "index.md"
    if file.is_relative_to(docs) and file.exists() and file.relative_to(docs).parts[0] not in NO_PAGES:
        return sources / file.relative_to(docs)
    path = file.relative_to(root).as_posix() if file.is_relative_to(root) else ""
    return sources / "project" / path if path in PROJECT_PAGES else None


def relinked(text: str, origin: Path, page: Path, root: Path, sources: Path) -> str:
    """Return a page with its links to files led to where the site has them."""

    def led(found: re.Match[str]) -> str:
        words, target, anchor = found[1], found[2], found[3] or ""
        if "://" in target or target.startswith("mailto:"):
            return found[0]
        file = Path(os.path.normpath(origin.parent / target))
        place = place_of(file, root, sources)
        if place is None and file.is_dir():
            return f"{words[1:-1]} (`{file.relative_to(root)}`)"
        if place is None and file.is_file():
            place = sources / "files" / file.relative_to(root).with_name(f"{file.name}.txt")
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, place)
            anchor = ""
        if place is None:
            return found[0]  # Sphinx says that it leads nowhere
        return f"{words}({os.path.relpath(place, page.parent)}{anchor})"

    return outside_of_code(text, lambda part: LINK.sub(led, part))


def places_of(generated: str) -> dict[str, tuple[str, str]]:
    """Return for each heading of the list of written pages its page's name, and the place there or ""."""
    places, page = {}, ""
    for level, heading in HEADING.findall(generated):
        page = f"reference/{heading}" if level == "##" else page
        places[heading] = page, "" if level == "##" else f"#{heading}"
    return places


def listed_pages(generated: str, titles: Mapping[str, str], docs: Path) -> str:
    """Return the list of written pages as the site has it: with links to them, which are its navigation."""
    said = SAID_OF_PAGE.findall(generated)
    rows = [f"- [{titles[f'reference/{name}']}]({name}.md): {what}" for name, what in said]
    added = [name for name, _ in said if not (docs / f"reference/{name}.md").exists()]
    return "\n".join([generated.partition("\n")[0], "", *rows, "", toctree(added, "")])


def to_written_pages(
    text: str, page: Path, sources: Path, places: Mapping[str, tuple[str, str]], titles: Mapping[str, str]
) -> str:
    """Return a page with links to the written pages that a checkout only lists; one by its name has its title."""

    def led(found: re.Match[str]) -> str:
        if Path(found[2]).name != Path(GENERATED).name or not found[3]:
            return found[0]
        name, inside = places[found[3][1:]]
        words = f"[{titles[name]}]" if found[1] == f"[{Path(name).name}]" else found[1]
        return f"{words}({os.path.relpath(sources / f'{name}.md', page.parent)}{inside})"

    return outside_of_code(text, lambda part: LINK.sub(led, part))


def outside_of_code(text: str, change: Callable[[str], str]) -> str:
    """Return a page whose text outside of code has been changed; the words of a link may hold code."""
    parts, end = [], 0
    for found in FENCED.finditer(text):
        if not found[0].startswith("```"):
            continue
        parts += [change(text[end : found.start()]), found[0]]
        end = found.end()
    return "".join([*parts, change(text[end:])])


def transitions_as_table(diagram: str) -> str:
    """Return a state diagram of Mermaid, which a browser draws with a script from a network, as a table."""
    rows = ["| From | To | By |", "|---|---|---|"]
    names = dict(re.findall(r'state "([^"]+)" as (\w+)', diagram))
    shown = {short: name for name, short in names.items()}
    for start, end, signals in re.findall(r"^\s*(\w+) --> (\w+): (.+)$", diagram, re.M):
        by = ", ".join(f"`{signal}`" for signal in signals.split(", "))
        rows.append(f"| {shown.get(start, f'`{start}`')} | {shown.get(end, f'`{end}`')} | {by} |")
    return "\n".join(rows)


def add_navigation(sources: Path) -> None:
    """Add the lists of pages by which Sphinx orders the site, as the first page's headings have them."""
    index = sources / "index.md"
    text = index.read_text("utf-8")
    trees: list[str] = []
    for part in re.split(r"^(?=## )", text, flags=re.M)[1:]:
        title = HEADING.match(part)
        assert title
        entries = LISTED.findall(re.split(r"^### ", part, maxsplit=1, flags=re.M)[0])
        for group in re.split(r"^(?=### )", part, flags=re.M)[1:]:
            entries.append(group_page(group, sources))
        trees.append(toctree(entries, title[2]))
    index.write_text("\n".join([text, *trees]), encoding="utf-8")
    decisions = sources / DECISIONS / "README.md"
    text = decisions.read_text("utf-8")
    decisions.write_text(f"{text}\n{toctree(LISTED.findall(text), '')}", encoding="utf-8")


def group_page(text: str, sources: Path) -> str:
    """Write the page of a group of pages, and return its path."""
    heading = HEADING.match(text)
    assert heading
    entries = LISTED.findall(text)
    folder = Path(entries[0]).parent
    path = folder / f"{re.sub(r'[^a-z]+', '_', heading[2].lower()).strip('_')}.md"
    body = LINK.sub(
        lambda found: f"{found[1]}({os.path.relpath(found[2], folder)}{found[3] or ''})",
        text[heading.end() :].strip("\n"),
    )
    tree = toctree([os.path.relpath(entry, folder) for entry in entries], "")
    (sources / path).write_text(f"# {heading[2]}\n\n{body}\n\n{tree}", encoding="utf-8")
    return path.as_posix()


def toctree(entries: list[str], caption: str) -> str:
    """Return a hidden list of pages."""
    named = [f":caption: {caption}"] if caption else []
    pages = dict.fromkeys(re.sub(r"\.(md|ipynb)$", "", entry) for entry in entries)
    return "\n".join(["```{toctree}", ":hidden:", *named, "", *pages, "```", ""])
