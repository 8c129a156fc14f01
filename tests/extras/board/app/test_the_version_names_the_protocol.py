"""What --version says of the firmware is what the host speaks."""

from __future__ import annotations

from tests.command_line import CommandLine

from musclewire.extras.board._serial.message_types import PROTOCOL_VERSION


def test_the_document_says_which_protocol_the_host_speaks(musclewire: CommandLine) -> None:
    assert musclewire("--version", "--json").json["firmware_protocol"] == PROTOCOL_VERSION
