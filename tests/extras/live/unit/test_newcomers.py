"""Connections that have shown nothing: how many may wait, for how long, who makes room, how little is said of it."""

from __future__ import annotations

import logging
from typing import Any

import pytest

from musclewire.extras.live._server.newcomers import FIRST_REQUEST_S, REPORT_S, Newcomers

MOST = 8


class Line:
    """A connection's transport, by what a newcomer needs of it."""

    def __init__(self, address: str, port: int) -> None:
        self.place, self.is_open = (address, port), True

    def get_extra_info(self, _name: str) -> tuple[str, int, int, int]:
        return (*self.place, 0, 0)  # as of IPv6

    def is_closing(self) -> bool:
        return not self.is_open

    def abort(self) -> None:
        self.is_open = False


def came(newcomers: Newcomers, *lines: Any, now_s: float = 0.0) -> None:
    for line in lines:
        newcomers.came(line, now_s)


def still_open(lines: list[Line]) -> list[int]:
    return [line.place[1] for line in lines if line.is_open]


def test_of_too_many_from_one_address_the_oldest_goes_and_other_addresses_lose_nothing() -> None:
    newcomers, other = Newcomers(MOST), Line("10.0.0.9", 1)
    lines = [Line("10.0.0.1", port) for port in range(20)]
    came(newcomers, other, *lines)
    assert still_open(lines) == [16, 17, 18, 19]  # half of all
    assert other.is_open


def test_of_too_many_in_all_the_oldest_goes_and_the_newest_is_let_in() -> None:
    newcomers, lines = Newcomers(MOST), [Line(f"10.0.0.{port}", port) for port in range(20)]
    came(newcomers, *lines)
    assert still_open(lines) == list(range(12, 20))


def test_whose_request_has_passed_is_never_closed_and_does_not_count() -> None:
    newcomers, known = Newcomers(MOST), [Line("10.0.0.1", port) for port in range(100)]
    for line in known:
        came(newcomers, line)
        newcomers.passed(line.place)
    came(newcomers, *(Line("10.0.0.1", port) for port in range(100, 200)))
    newcomers.look(FIRST_REQUEST_S + 1.0)
    assert len(still_open(known)) == 100


def test_who_is_gone_makes_room() -> None:
    newcomers, first = Newcomers(MOST), Line("10.0.0.1", 0)
    came(newcomers, first)
    for port in range(1, 20):
        line = Line("10.0.0.1", port)
        came(newcomers, line)
        newcomers.gone(line)  # type: ignore[arg-type]
    assert first.is_open


def test_who_sends_no_valid_request_in_time_is_closed() -> None:
    newcomers, line = Newcomers(MOST), Line("10.0.0.1", 0)
    came(newcomers, line, now_s=10.0)
    newcomers.look(10.0 + FIRST_REQUEST_S)
    assert line.is_open
    newcomers.look(10.1 + FIRST_REQUEST_S)
    assert not line.is_open
    assert len(newcomers) == 0


def test_without_a_file_descriptor_the_oldest_makes_room() -> None:
    newcomers, lines = Newcomers(MOST), [Line("10.0.0.1", port) for port in range(3)]
    came(newcomers, *lines)
    newcomers.not_accepted("Too many open files")
    assert still_open(lines) == [1, 2]


def test_what_is_refused_is_said_once_a_minute_and_counted(caplog: pytest.LogCaptureFixture) -> None:
    newcomers = Newcomers(MOST)
    with caplog.at_level(logging.WARNING, "musclewire.live"):
        for second in range(int(2 * REPORT_S)):
            came(newcomers, *(Line("10.0.0.1", 100 * second + one) for one in range(10)), now_s=float(second))
            newcomers.not_accepted("Too many open files")
            newcomers.look(float(second))
    assert len(caplog.messages) == 2
    assert caplog.messages[0].startswith("closed 7 connections: ")
    assert sum(int(text.split()[1]) for text in caplog.messages) > 10 * REPORT_S
