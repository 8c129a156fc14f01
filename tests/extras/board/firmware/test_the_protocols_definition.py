"""One definition of the serial messages: Python, C and the page follow from it, and it allows no contradiction."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from firmware.protocol import DEFINITION, Protocol, page, protocol, written
from pydantic import ValidationError

from musclewire.controllers import Event, State
from musclewire.extras.board import MessageKind, SerialFrame, read_message
from musclewire.extras.board._serial.message_types import LAYOUTS
from musclewire.extras.board._serial.messages import BoardEvent

FILES = written()
# Version 2 as boards in use speak it: these never change.
VERSION_2 = {
    "HELLO": (0x01, "<"),
    "ARM": (0x02, "<"),
    "DRIVE": (0x03, "<f"),
    "TARGET": (0x04, "<f"),
    "OFF": (0x05, "<"),
    "STREAM": (0x06, "<H"),
    "KEEP": (0x07, "<"),
    "CORRECT": (0x08, "<ff"),
    "INJECT": (0x7F, "<B"),
    "IDENTITY": (0x81, "<BBBBIIfffHIB16s12s24s"),
    "SAMPLE": (0x82, "<IBBHffffff"),
    "EVENT": (0x83, "<IBBf"),
    "ACKNOWLEDGEMENT": (0x84, "<HBB"),
    "CORRECTION": (0x85, "<ff"),
}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_the_committed_files_are_what_the_definition_gives(file: Path) -> None:
    assert file.read_text("utf-8") == FILES[file], "run: python firmware/protocol.py"


def test_the_page_says_the_version_and_has_each_message() -> None:
    text = page()
    assert f"Version {protocol().version}, between a host and a board" in text
    assert f"| 1 | version of the protocol: {protocol().version} |" in text
    assert [row.in_c for row in protocol().message if not row.only_with and f" {row.in_c}" not in text] == []
    assert "<!--" not in text


def test_version_2_is_as_boards_in_use_speak_it() -> None:
    assert protocol().version == 2
    assert {kind.name: (kind.value, LAYOUTS[kind].format) for kind in MessageKind} == VERSION_2


def test_states_and_events_of_a_message_are_those_of_the_protection_table() -> None:
    for state in State:
        message = read_message(
            SerialFrame(MessageKind.EVENT, 0, LAYOUTS[MessageKind.EVENT].pack(7, state, Event.STOPPED, 0.0))
        )
        assert message == BoardEvent(7, State(state), Event.STOPPED, 0.0)


def test_a_frame_of_the_host_or_of_another_length_is_no_message_of_a_board() -> None:
    assert read_message(SerialFrame(MessageKind.DRIVE, 0, bytes(4))) is None
    assert read_message(SerialFrame(0x55, 0, b"")) is None
    for kind in (MessageKind.IDENTITY, MessageKind.SAMPLE, MessageKind.EVENT, MessageKind.ACKNOWLEDGEMENT):
        assert read_message(SerialFrame(kind, 0, bytes(LAYOUTS[kind].size + 1))) is None


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda of: of["message"][1].update(number=1), "messages: a number is there twice"),
        (lambda of: of["message"][0].update(number=0x90), "the board's numbers, and only they"),
        (lambda of: of["message"][2]["field"][0].update(type="text", bytes=89), "89 bytes do not fit"),
        (lambda of: of["message"][2].update(colour="red"), "colour"),
    ],
)
def test_a_definition_that_contradicts_itself_is_refused(change: Callable[[Any], None], says: str) -> None:
    document = tomllib.loads(DEFINITION.read_text("utf-8"))
    change(document)
    with pytest.raises(ValidationError, match=says):
        Protocol.model_validate(document)
