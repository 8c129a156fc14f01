"""The API's documents are valid, and what the server really sends is what they say."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

import jsonschema
import pytest
from openapi_spec_validator import OpenAPIV31SpecValidator
from websockets.sync.client import connect

BENCH = "/api/v1/benches/simulated"
# Sections and fields that version 3.0.0 of the specification asks for.
ASYNCAPI_FIELDS = {"asyncapi", "info", "servers", "channels", "operations", "components"}


@pytest.fixture
def openapi(server: Any) -> dict[str, Any]:
    document: dict[str, Any] = server.http.get("/api/v1/openapi.json").json()
    return document


@pytest.fixture
def asyncapi(server: Any) -> dict[str, Any]:
    document: dict[str, Any] = server.http.get("/api/v1/asyncapi.json").json()
    return document


def references(value: Any) -> Iterator[str]:
    """Every reference anywhere in a document."""
    if isinstance(value, dict):
        yield from (one for key, one in value.items() if key == "$ref")
        for one in value.values():
            yield from references(one)
    elif isinstance(value, list):
        for one in value:
            yield from references(one)


def found(document: dict[str, Any], reference: str) -> Any:
    """What a reference within a document leads to; KeyError if nowhere."""
    value: Any = document
    for part in reference.removeprefix("#/").split("/"):
        value = value[part]
    return value


def schema(document: dict[str, Any], name: str) -> dict[str, Any]:
    """A schema of a document by itself."""
    return {"$ref": f"#/components/schemas/{name}", "components": document["components"]}


def test_the_openapi_document_is_valid(openapi: dict[str, Any]) -> None:
    OpenAPIV31SpecValidator(openapi).validate()  # type: ignore[arg-type]


def test_every_route_of_the_interface_is_in_it_and_none_takes_a_path_or_a_kind_of_rig(openapi: dict[str, Any]) -> None:
    routes = {f"{method.upper()} {path}" for path, methods in openapi["paths"].items() for method in methods}
    assert {
        *(f"{method} /api/v1/benches/{{bench}}/control" for method in ("POST", "PUT", "DELETE")),
        *("GET /api/v1/benches", "GET /api/v1/benches/{bench}", "GET /api/v1/benches/{bench}/rows"),
        *("POST /api/v1/benches/{bench}/commands", "POST /api/v1/benches/{bench}/stop"),
        *("GET /api/v1/recordings", "GET /api/v1/recordings/{name}", "GET /api/v1/recordings/{name}/rows"),
    } == routes
    fields = set(re.findall(r'"([a-z_]+)": \{', json.dumps(openapi["components"]["schemas"])))
    assert not fields & {"rig", "kind_of_rig", "path", "file", "wire_file", "rig_file", "folder"}


def test_what_the_routes_answer_is_what_the_document_says(server: Any, openapi: dict[str, Any]) -> None:
    answers = {
        "BenchList": server.http.get("/api/v1/benches"),
        "RowsAnswer": server.http.get(f"{BENCH}/rows"),
        "PhaseAnswer": server.http.post(f"{BENCH}/stop"),
        "ControlState": server.http.post(f"{BENCH}/control", json={"name": "x"}),
        "RecordingList": server.http.get("/api/v1/recordings"),
        "ProblemAnswer": server.http.get("/api/v1/benches/none"),
    }
    for name, answer in answers.items():
        jsonschema.validate(answer.json(), schema(openapi, name))


def test_the_asyncapi_document_has_its_sections_and_every_reference_leads_somewhere(asyncapi: dict[str, Any]) -> None:
    assert asyncapi["asyncapi"] == "3.0.0"
    assert set(asyncapi) == ASYNCAPI_FIELDS
    assert {"title", "version"} <= set(asyncapi["info"])
    assert all({"host", "protocol"} <= set(one) for one in asyncapi["servers"].values())
    for one in asyncapi["operations"].values():
        assert one["action"] in ("send", "receive")
        for reference in references(one["messages"]):
            assert reference.startswith("#/channels/live/messages/")
    targets = [found(asyncapi, reference) for reference in references(asyncapi)]
    assert len(targets) > 30
    for one in asyncapi["components"]["schemas"].values():
        jsonschema.Draft202012Validator.check_schema(one)


def test_every_message_that_the_server_sends_is_one_of_the_document(server: Any, asyncapi: dict[str, Any]) -> None:
    by_type = {
        one["properties"]["type"]["const"]: name
        for name, one in asyncapi["components"]["schemas"].items()
        if "const" in one.get("properties", {}).get("type", {})
    }
    seen = set()
    with connect(server.socket) as socket:
        socket.send('{"type":"ask_control","bench":"simulated","name":"Ann"}')
        socket.send('{"type":"command","id":1,"bench":"simulated","command":{"do":"stop"}}')
        socket.send("nonsense")
        while not {"hello", "state", "control", "ping", "answer", "problem", "rows"} <= seen:
            server.bench.add_row(len(seen) * 0.1, 1.0, 0.5, 3.0, 0.5)
            message = json.loads(socket.recv(timeout=20))
            jsonschema.validate(message, schema(asyncapi, by_type[message["type"]]))
            seen.add(message["type"])


def test_the_page_for_people_fetches_nothing_from_elsewhere_and_has_no_script(server: Any) -> None:
    text = server.http.get("/api/v1/docs").text
    assert "<script" not in text
    assert "style=" not in text
    assert re.findall(r'(?:src|href)="([^"]+)"', text) == ["/api/v1/docs.css"]
    assert server.http.get("/api/v1/docs.css").headers["content-type"].startswith("text/css")
    assert server.http.get("/docs").status_code == server.http.get("/redoc").status_code == 404
