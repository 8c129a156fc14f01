"""The API in the two forms that programs read, OpenAPI 3.1 and AsyncAPI 3.0, both from the records themselves."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any, get_args

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import TypeAdapter

from musclewire.extras.live._messages import COMMANDS
from musclewire.extras.live._server.socket_messages import FROM_PAGE, TO_PAGE, FromPage, ToPage

__all__ = ["LIVE", "asyncapi_document", "openapi_document", "records_of"]

LIVE = "/api/v1/live"
REFERENCE = "#/components/schemas/{model}"
TITLE = "musclewire serve"
DESCRIPTION = (
    "State and commands of the rigs that a running 'musclewire serve' has open. All quantities are in SI units. "
    "On another address than loopback every request shows a token: Authorization: Bearer, or the cookie of the page."
)


def openapi_document(app: FastAPI) -> dict[str, Any]:
    """Return the HTTP routes as an OpenAPI document."""
    document = get_openapi(
        title=TITLE, version=version("musclewire"), description=DESCRIPTION, routes=app.routes, openapi_version="3.1.0"
    )
    parts = document.setdefault("components", {})
    command = COMMANDS.json_schema(ref_template=REFERENCE)
    parts.setdefault("schemas", {}).update({**command.pop("$defs", {}), "Command": command})
    parts["securitySchemes"] = {"token": {"type": "http", "scheme": "bearer"}}
    document["security"] = [{}, {"token": []}]
    return document


def asyncapi_document(host: str = "127.0.0.1:8765") -> dict[str, Any]:
    """Return the WebSocket's messages as an AsyncAPI document; ``host`` is where the server is reached."""
    received, sent = records_of(FromPage), records_of(ToPage)
    return {
        "asyncapi": "3.0.0",
        "info": {"title": TITLE, "version": version("musclewire"), "description": DESCRIPTION},
        "servers": {"local": {"host": host, "protocol": "ws"}},
        "channels": {
            "live": {
                "address": LIVE,
                "messages": {
                    one.__name__: {"$ref": f"#/components/messages/{one.__name__}"} for one in (*received, *sent)
                },
            }
        },
        "operations": {"receive": operation("receive", received), "send": operation("send", sent)},
        "components": {
            "messages": {one.__name__: message(one) for one in (*received, *sent)},
            "schemas": {**schemas_of(FROM_PAGE), **schemas_of(TO_PAGE)},
        },
    }


def records_of(union: Any) -> tuple[type[Any], ...]:
    """Return the records of an annotated union."""
    return get_args(get_args(union)[0])


def operation(action: str, records: Sequence[type[Any]]) -> dict[str, Any]:
    """Return what the server does with some of the channel's messages."""
    return {
        "action": action,
        "channel": {"$ref": "#/channels/live"},
        "messages": [{"$ref": f"#/channels/live/messages/{one.__name__}"} for one in records],
    }


def message(record: type[Any]) -> dict[str, Any]:
    """Return a record as a message."""
    return {
        "name": record.__name__,
        "summary": (record.__doc__ or "").strip(),
        "contentType": "application/json",
        "payload": {"$ref": f"#/components/schemas/{record.__name__}"},
    }


def schemas_of(adapter: TypeAdapter[Any]) -> dict[str, Any]:
    """Return the schemas of a union's records and of all they are made of, by name."""
    definitions: dict[str, Any] = adapter.json_schema(ref_template=REFERENCE)["$defs"]
    return definitions
