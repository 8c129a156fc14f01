"""The API's document is valid, and what the server really sends is what it and the records of messages say."""

from __future__ import annotations

import json
import re
from typing import Any

import jsonschema
import pytest
from openapi_spec_validator import OpenAPIV31SpecValidator
from pydantic import TypeAdapter
from websockets.sync.client import connect

from musclewire.extras.live import ToPage

BENCH = "/api/v1/benches/simulated"


@pytest.fixture
def openapi(server: Any) -> dict[str, Any]:
    document: dict[str, Any] = server.http.get("/api/v1/openapi.json").json()
    return document


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


def test_a_bench_is_listed_as_simulated_before_it_is_switched_on(server: Any) -> None:
    for simulated in (True, False):
        server.bench.change(phase="off", rig=None, simulated=simulated)
        (listed,) = server.http.get("/api/v1/benches").json()["benches"]
        assert listed["simulated"] is simulated


def test_every_message_that_the_server_sends_is_one_of_its_records(server: Any) -> None:
    record: TypeAdapter[Any] = TypeAdapter(ToPage)
    seen = set()
    with connect(server.socket) as socket:
        socket.send('{"type":"ask_control","bench":"simulated","name":"Ann"}')
        socket.send('{"type":"command","id":1,"bench":"simulated","command":{"do":"stop"}}')
        socket.send("nonsense")
        while not {"hello", "state", "control", "ping", "answer", "problem", "rows"} <= seen:
            server.bench.add_row(len(seen) * 0.1, 1.0, 0.5, 3.0, 0.5)
            seen.add(record.validate_json(socket.recv(timeout=20)).type)


def test_no_page_loads_scripts_from_elsewhere(server: Any) -> None:
    for page in ("/docs", "/redoc", "/api/v1/docs"):
        assert server.http.get(page).status_code == 404
