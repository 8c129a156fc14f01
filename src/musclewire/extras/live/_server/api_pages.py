"""The API for people: tables of routes, commands and messages, as a page of the documentation and as a page of its own.

FastAPI's own pages load scripts from the internet; the server's works without.
"""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, get_args

from pydantic import BaseModel

from musclewire.extras.live._messages import Command, Reference
from musclewire.extras.live._server.documents import LIVE, records_of
from musclewire.extras.live._server.socket_messages import FromPage, ToPage

__all__ = ["PageSection", "html_page", "markdown_page", "sections"]


class PageSection(NamedTuple):
    """A heading, a paragraph in Markdown without links, and a table."""

    heading: str
    text: str
    headers: tuple[str, ...]
    rows: list[tuple[str, ...]]


def sections(openapi: Mapping[str, Any]) -> list[PageSection]:
    """Return the whole API as sections."""
    return [
        PageSection(
            "Routes",
            'Answers are JSON. One that is not 2xx is `{"problem": "one line"}`. `/api/v1/openapi.json` has all of it '
            "for programs.",
            ("Route", "Does"),
            [(f"`{method.upper()} {path}`", one_line(what)) for path, method, what in operations(openapi)],
        ),
        PageSection(
            "Commands",
            "To `POST .../commands`, or in a `command` message. A field after which nothing is said is required.",
            ("Command", "Fields", "Does"),
            [(f"`{name_of(one)}`", fields(one, {"do"}), summary(one)) for one in records_of(Command)],
        ),
        PageSection(
            "References",
            "The field `reference` of `control`, in the unit of the model's quantity: strain as a fraction, m, N.",
            ("Kind", "Fields", "Means"),
            [(f"`{name_of(one)}`", fields(one, {"kind"}), summary(one)) for one in get_args(get_args(Reference)[0])],
        ),
        PageSection(
            "Messages to the server",
            f"Over the WebSocket `{LIVE}`, each a JSON text with a field `type`; `/api/v1/asyncapi.json` has all of it "
            "for programs.",
            ("Message", "Fields", "Means"),
            [(f"`{name_of(one)}`", fields(one, {"type"}), summary(one)) for one in records_of(FromPage)],
        ),
        PageSection(
            "Messages from the server",
            "On the same WebSocket. A connection that takes too little in loses rows first and is then closed.",
            ("Message", "Fields", "Means"),
            [(f"`{name_of(one)}`", fields(one, {"type"}), summary(one)) for one in records_of(ToPage)],
        ),
    ]


def operations(openapi: Mapping[str, Any]) -> Iterable[tuple[str, str, str]]:
    """Return path, method and description of every route."""
    for path, methods in openapi["paths"].items():
        for method, what in methods.items():
            yield path, method, what["description"]


def one_line(text: str) -> str:
    """Return a text on one line."""
    return " ".join(text.split())


def name_of(record: type[BaseModel]) -> str:
    """Return the word by which a record is known: the value of its first field."""
    first = next(iter(record.model_fields.values()))
    return str(get_args(first.annotation)[0])


def summary(record: type[BaseModel]) -> str:
    """Return the first sentence of a record's docstring."""
    return one_line((record.__doc__ or "").split("\n\n")[0]).replace("``", "`")


def fields(record: type[BaseModel], left_out: set[str]) -> str:
    """Return the fields of a record with their defaults."""
    found = []
    for name, field in record.model_fields.items():
        if name not in left_out:
            default = "" if field.is_required() else f" ({'null' if field.default is None else field.default})"
            found.append(f"`{name}`{default}")
    return ", ".join(found)


def markdown_page(openapi: Mapping[str, Any]) -> str:
    """Return the sections as Markdown."""
    return "\n".join(line for one in sections(openapi) for line in markdown_section(one))


def markdown_section(section: PageSection) -> list[str]:
    """Return a section as lines of Markdown."""
    table = [section.headers, tuple("---" for _ in section.headers), *section.rows]
    return [f"## {section.heading}", "", section.text, "", *(f"| {' | '.join(row)} |" for row in table), ""]


def html_page(openapi: Mapping[str, Any]) -> str:
    """Return the sections as a page that needs nothing from elsewhere."""
    body = "".join(html_section(one) for one in sections(openapi))
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>API of musclewire serve</title>'
        '<meta name="viewport" content="width=device-width"><link rel="stylesheet" href="/api/v1/docs.css"></head>'
        f"<body><main><h1>API of musclewire serve</h1>{body}</main></body></html>"
    )


def html_section(section: PageSection) -> str:
    """Return a section as HTML."""
    head = "".join(f"<th>{html.escape(one)}</th>" for one in section.headers)
    rows = "".join("<tr>" + "".join(f"<td>{marked(cell)}</td>" for cell in row) + "</tr>" for row in section.rows)
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    return f"<h2>{html.escape(section.heading)}</h2><p>{marked(section.text)}</p>{table}"


def marked(text: str) -> str:
    """Return Markdown with code in back quotes as HTML."""
    parts = html.escape(text, quote=False).split("`")
    return "".join(f"<code>{part}</code>" if place % 2 else part for place, part in enumerate(parts))
