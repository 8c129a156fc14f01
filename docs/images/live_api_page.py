"""The page reference/live_api of the site, from the records and routes that the server of the live page runs by."""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

from musclewire.extras.live import LIVE, Command, FromPage, Reference, Session, ToPage, make_app

HEAD = """# The live API

For programmers whose program watches or moves a wire through a running `musclewire serve`.
`musclewire serve` shows a wire on a page; the page uses nothing but what is here, so a program can do all that it
does. From Python, `mw.LiveClient` does it
([example](../../examples/operate_a_wire_over_the_live_api.py)):

    with mw.LiveClient("http://127.0.0.1:8765") as client, client.control("my program"):
        client.command("switch_on")
        client.wait_for("ready")
        client.command("characterize", cycles=1)
        client.wait_for("busy"), client.wait_for("ready", timeout_s=300)
        client.command("fit")
        client.command("control", reference={"kind": "steer"})
        client.command("target", value=0.02)

All quantities are in SI units, strain as a fraction. The server describes its routes to programs as OpenAPI, at
`/api/v1/openapi.json`.

## Who may do what

- **Anybody who may see the page may stop.** `POST .../stop` and the command `stop` need no control; a stop is
  answered once the drive is off, and is read however much else comes with it. An order to switch on that came before
  it and has not been carried out is refused, even if the rig is just being opened; one that comes afterwards counts.
- **Everything else needs control**, which one person or program has at a time. `POST .../control` takes it if it is
  free, and otherwise asks the holder, who answers. A lease ends 0.75 s after the last sign of life, at rest
  5 s after it: over HTTP a `PUT
  .../control`, over the WebSocket a `pong` to the server's `ping`. Then a heated run ends and the rig goes to its
  sense voltage.
- **No route takes a rig file, a kind of rig or a path.** Rigs come from the command line of `serve`; recordings and
  models are named, and lie in the session's folder.
- **A token is needed.** Without `--host` only this machine reaches the server, and the token is that of the user, which
  `mw.LiveClient` finds for programs of the same user. With another `--host` a token is made. `--token-file` reads
  one of your own, which only its owner may read. It is shown as `Authorization: Bearer TOKEN` or
  by the cookie that the printed link leaves (`HttpOnly`, `SameSite=Strict`). The connection is not encrypted: through
  a network that is not your own use an SSH tunnel (`ssh -L 8765:localhost:8765 THE_MACHINE`).
- **Pages of other sites are refused**: by `Origin` on the WebSocket and on every POST, PUT and DELETE, and by `Host`
  on every request, so that no other name can be pointed here. Bodies are JSON of at most 512 KiB; of a connection
  400 messages a second are read, and any stop.
- **A slow connection delays nobody.** It loses rows, keeps the newest state, and is closed when its messages do not
  move.
- **A connection that says nothing keeps nobody out.** Until its first valid request it is one of few, has 5 s, and
  makes room if there are too many. Connections that have sent one are not limited.

`python -m benchmarks.live_stop` measures stops over both ways, in the middle of heated runs, and with
`--while-switching-on 200` counts those that are lost while a rig is switched on; `python -m
benchmarks.malformed_messages` sends 10,000 malformed requests and messages and holds that nothing changes.

Why it is built so: [the live page](../explanation/decisions/live-page.md).

"""


def page() -> str:
    """Return the page."""
    openapi = make_app(Session([], Path())).openapi()
    routes = [
        (f"`{method.upper()} {path}`", " ".join(what["description"].split()))
        for path, methods in openapi["paths"].items()
        for method, what in methods.items()
    ]
    return HEAD + "\n".join(
        (
            section(
                "Routes",
                'Answers are JSON. One that is not 2xx is `{"problem": "one line"}`. `/api/v1/openapi.json` has all of '
                "it for programs.",
                ("Route", "Does"),
                routes,
            ),
            section(
                "Commands",
                "To `POST .../commands`, or in a `command` message. A field after which nothing is said is required.",
                ("Command", "Fields", "Does"),
                rows_of(Command),
            ),
            section(
                "References",
                "The field `reference` of `control`, in the unit of the model's quantity: strain as a fraction, m, N.",
                ("Kind", "Fields", "Means"),
                rows_of(Reference),
            ),
            section(
                "Messages to the server",
                f"Over the WebSocket `{LIVE}`, each a JSON text with a field `type`.",
                ("Message", "Fields", "Means"),
                rows_of(FromPage),
            ),
            section(
                "Messages from the server",
                "On the same WebSocket. A connection that takes too little in loses rows first and is then closed.",
                ("Message", "Fields", "Means"),
                rows_of(ToPage),
            ),
        )
    )


def section(heading: str, text: str, headers: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Return a heading, a paragraph and a table."""
    table = [headers, tuple("---" for _ in headers), *rows]
    return "\n".join((f"## {heading}", "", text, "", *(f"| {' | '.join(row)} |" for row in table), ""))


def rows_of(union: Any) -> list[tuple[str, ...]]:
    """Return a row for each record of a union: its word, that of its first field, the other fields, and what it is."""
    found = []
    for record in get_args(get_args(union)[0]):
        (_, first), *fields = record.model_fields.items()
        described = ", ".join(f"`{name}`{default_of(field)}" for name, field in fields)
        means = " ".join((record.__doc__ or "").split("\n\n")[0].split()).replace("``", "`")
        found.append((f"`{get_args(first.annotation)[0]}`", described, means))
    return found


def default_of(field: Any) -> str:
    """Return the default of a field in brackets, nothing for one that is required."""
    if field.is_required():
        return ""
    return f" ({'null' if field.default is None else field.default})"
