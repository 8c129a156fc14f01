"""Options of the command that serves the live page."""

from __future__ import annotations

from musclewire.app import option

HOST = option("--host", help="Name or address to listen at.")
PORT = option("--port", help="Port to listen at; if it is taken, the next that is free.", min=1, max=65535)
TOKEN_FILE = option(
    "--token-file",
    help="File with the token that everybody must show. Default: on loopback the user's own, else a new one.",
)
OPEN = option("--open", help="Open the page in the browser.")
