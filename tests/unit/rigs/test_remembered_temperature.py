"""How warm a wire counts at opening by what was kept of it; texts in memory, clocks that a test sets."""

from __future__ import annotations

import json
import tempfile
from math import inf, nan
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.unit.rigs.remembered_wire import AMBIENT_K, BOARD, LIMIT_K, LIMITS, NOW_S

from musclewire.errors import CallerError
from musclewire.rigs._remembered_temperature import (
    AHEAD_S,
    KeptFile,
    RememberedTemperature,
    TemperatureKeeper,
    WireTemperature,
    cooled_k,
    file_name_of,
    opened,
    state_folder,
    text_of,
    warmest_k,
)

TIME_CONSTANT_S = 0.9


class KeptInMemory:
    """A text in memory; ``reading`` and ``writing`` are errors that are raised instead."""

    place = "kept.json"

    def __init__(self, text: str | None = None) -> None:
        self.text, self.texts = text, [text]
        self.reading: Exception | None = None
        self.writing: Exception | None = None

    def read(self) -> str | None:
        if self.reading is not None:
            raise self.reading
        return self.text

    def write(self, text: str) -> None:
        if self.writing is not None:
            raise self.writing
        self.text = text
        self.texts.append(text)

    @property
    def stored(self) -> WireTemperature:
        kept = json.loads(str(self.text))
        return WireTemperature(kept["temperature_k"], kept["unix_time_s"])


def kept_at(temperature_k: float, before_s: float) -> KeptInMemory:
    return KeptInMemory(text_of(BOARD, WireTemperature(temperature_k, NOW_S - before_s)))


def test_a_device_without_an_identity_begins_cold_and_keeps_nothing() -> None:
    kept = KeptInMemory()
    remembered = RememberedTemperature(None, LIMITS, kept=kept)
    assert remembered.at_opening == (AMBIENT_K, True, None)
    remembered.note(400.0)
    remembered.close()
    remembered.close()
    assert kept.texts == [None]


def test_a_device_of_which_nothing_is_kept_begins_cold() -> None:
    assert opened(BOARD, LIMITS, KeptInMemory(), NOW_S) == (AMBIENT_K, True, None)


@pytest.mark.parametrize(("passed", "left"), [(0.0, 1.0), (1.0, 0.36788), (2.0, 0.13534), (1e9, 0.0)])
def test_a_wire_cools_by_its_limits_heat_balance_over_the_time_passed(passed: float, left: float) -> None:
    found = opened(BOARD, LIMITS, kept_at(AMBIENT_K + 100.0, passed * TIME_CONSTANT_S), NOW_S)
    assert found.temperature_k == pytest.approx(AMBIENT_K + 100.0 * left, abs=1e-3)
    assert (found.known, found.reason) == (True, None)


@pytest.mark.parametrize("back_s", [0.0, 1.0, 1e9])
def test_a_clock_that_went_back_counts_as_no_time_passed(back_s: float) -> None:
    assert opened(BOARD, LIMITS, kept_at(410.0, -back_s), NOW_S).temperature_k == pytest.approx(410.0)


def test_a_wire_that_was_colder_than_the_air_counts_as_the_air_and_one_above_the_limit_as_it_was() -> None:
    assert opened(BOARD, LIMITS, kept_at(250.0, 0.0), NOW_S).temperature_k == AMBIENT_K
    assert opened(BOARD, LIMITS, kept_at(LIMIT_K + 30.0, 0.0), NOW_S).temperature_k == pytest.approx(LIMIT_K + 30.0)


def with_numbers(temperature_k: object, unix_time_s: object, identity: object = BOARD) -> str:
    return json.dumps({"identity": identity, "temperature_k": temperature_k, "unix_time_s": unix_time_s})


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[" * 4000,
        "[]",
        "{}",
        "7",
        "null",
        "\x00\x00\x00",
        with_numbers(nan, NOW_S),
        with_numbers(inf, NOW_S),
        with_numbers(-3.0, NOW_S),
        with_numbers(0.0, NOW_S),
        with_numbers(5000.0, NOW_S),
        with_numbers(None, NOW_S),
        with_numbers("warm", NOW_S),
        with_numbers(10**400, NOW_S),
        with_numbers(400.0, nan),
        with_numbers(400.0, None),
        with_numbers(400.0, NOW_S, "another board"),
        with_numbers(400.0, NOW_S, None),
        text_of(BOARD, WireTemperature(400.0, NOW_S))[:40],
    ],
)
def test_a_text_that_makes_no_sense_counts_as_the_limit_and_is_said(text: str) -> None:
    kept = KeptInMemory(text)
    found = opened(BOARD, LIMITS, kept, NOW_S)
    assert (found.temperature_k, found.known) == (LIMIT_K, False)
    assert found.reason is not None
    assert found.reason.startswith("kept.json: how warm the wire was cannot be read (")
    assert found.reason.endswith("it counts as 200 C, its limit, and cools from there at the sense voltage")
    assert "\n" not in found.reason
    assert kept.stored == (LIMIT_K, NOW_S)


@given(st.text())
def test_any_text_gives_a_temperature_between_air_and_melting(text: str) -> None:
    assert AMBIENT_K <= opened(BOARD, LIMITS, KeptInMemory(text), NOW_S).temperature_k < 1583.0


def test_limits_without_a_highest_temperature_leave_the_melting_point() -> None:
    limits = LIMITS._replace(maximum_temperature_k=inf)
    assert opened(BOARD, limits, KeptInMemory("?"), NOW_S).temperature_k == 1583.0


def test_a_file_of_somebody_else_that_may_not_be_read_counts_as_the_limit() -> None:
    kept = kept_at(300.0, 0.0)
    kept.reading = PermissionError(13, "Permission denied")
    found = opened(BOARD, LIMITS, kept, NOW_S)
    assert (found.temperature_k, found.known) == (LIMIT_K, False)
    assert "Permission denied" in str(found.reason)


@pytest.mark.parametrize("error", [PermissionError(13, "Permission\ndenied"), CallerError("folder: cannot be written")])
def test_a_folder_that_cannot_be_written_is_said_at_opening_and_raises_nothing_later(error: Exception) -> None:
    kept = kept_at(400.0, 0.0)
    kept.writing = error
    remembered = RememberedTemperature(BOARD, LIMITS, kept=kept, unix_time_s=lambda: NOW_S)
    found = remembered.at_opening
    assert (found.temperature_k, found.known) == (pytest.approx(400.0), True)
    assert str(found.reason).startswith("kept.json: how warm the wire is cannot be kept (")
    assert "MUSCLEWIRE_STATE_HOME" in str(found.reason)
    assert "\n" not in str(found.reason)
    remembered.note(420.0)
    remembered.close()
    assert len(kept.texts) == 1


def test_closing_keeps_what_was_noted_last_at_the_time_of_its_note() -> None:
    kept, times_s = KeptInMemory(), iter([NOW_S, NOW_S + 1.0, NOW_S + 2.0, NOW_S + 99.0])
    remembered = RememberedTemperature(BOARD, LIMITS, kept=kept, unix_time_s=lambda: next(times_s))
    remembered.note(390.0)
    remembered.note(380.0)
    remembered.close()
    assert kept.stored == (380.0, NOW_S + 2.0)
    assert set(json.loads(str(kept.text))) == {"identity", "temperature_k", "unix_time_s"}
    remembered.note(450.0)
    remembered.close()
    assert kept.stored == (380.0, NOW_S + 2.0)


def test_a_rig_that_never_exchanges_leaves_what_it_found_cooled_until_its_opening() -> None:
    kept = kept_at(AMBIENT_K + 100.0, TIME_CONSTANT_S)
    RememberedTemperature(BOARD, LIMITS, kept=kept, unix_time_s=lambda: NOW_S).close()
    assert kept.stored == (pytest.approx(AMBIENT_K + 36.788, abs=1e-3), NOW_S)


def test_it_writes_once_a_second_at_most_and_only_what_is_new() -> None:
    kept, seconds = KeptInMemory(), [0.0]
    keeper = TemperatureKeeper(BOARD, LIMITS, kept, elapsed_s=lambda: seconds[0])
    keeper.write_if_due()
    assert kept.texts == [None]
    for tenth in range(31):  # 20 notes a second, a look every 0.1 s
        seconds[0] = tenth / 10
        keeper.noted = WireTemperature(300.0 + tenth, NOW_S + seconds[0])
        keeper.write_if_due()
    assert len(kept.texts) - 1 == 4  # at 0, 1, 2 and 3 s
    seconds[0] = 50.0
    keeper.write_if_due()
    assert len(kept.texts) - 1 == 4


def test_while_it_runs_it_keeps_what_the_largest_drive_can_make_of_the_wire_until_the_next_time() -> None:
    kept = KeptInMemory()
    keeper = TemperatureKeeper(BOARD, LIMITS, kept, elapsed_s=lambda: 0.0)
    keeper.noted = WireTemperature(AMBIENT_K, NOW_S)
    keeper.write_if_due()
    assert kept.stored == (warmest_k(AMBIENT_K, LIMITS, AHEAD_S), NOW_S + AHEAD_S)
    keeper.write_last()
    assert kept.stored == (AMBIENT_K, NOW_S)


def test_an_error_of_the_folder_ends_no_thread_and_the_next_second_writes_again() -> None:
    kept, seconds = KeptInMemory(), [0.0]
    keeper = TemperatureKeeper(BOARD, LIMITS, kept, elapsed_s=lambda: seconds[0])
    keeper.noted, kept.writing = WireTemperature(400.0, NOW_S), OSError(28, "No space left on device")
    keeper.write_if_due()
    keeper.write_last()
    keeper.noted, kept.writing, seconds[0] = WireTemperature(401.0, NOW_S), None, 1.0
    keeper.write_if_due()
    assert kept.stored.temperature_k >= 401.0


@given(
    st.floats(AMBIENT_K, LIMIT_K),
    st.lists(st.floats(0.0, 3.6), min_size=1, max_size=30),
    st.floats(10.0, 26.0),
    st.floats(0.0, 5.0),
)
def test_no_drive_within_the_limits_leaves_a_warmer_wire_than_a_kill_finds_kept(
    begin_k: float, drive_v: list[float], ohm: float, opened_after_s: float
) -> None:
    stored = WireTemperature(warmest_k(begin_k, LIMITS, AHEAD_S), NOW_S + AHEAD_S)
    temperature_k, dt_s = begin_k, AHEAD_S / len(drive_v)
    for voltage_v in drive_v:  # each for a while, in closed form; the protection ends it at the limit
        settled_k = AMBIENT_K + (voltage_v / (ohm + 1.0)) ** 2 * ohm / LIMITS.heat_loss_w_per_k
        after_k = settled_k + (temperature_k - settled_k) * 2.718281828459045 ** (-dt_s / TIME_CONSTANT_S)
        temperature_k = min(after_k, LIMIT_K)
    true_k = cooled_k(WireTemperature(temperature_k, NOW_S + AHEAD_S), LIMITS, NOW_S + AHEAD_S + opened_after_s)
    assert cooled_k(stored, LIMITS, NOW_S + AHEAD_S + opened_after_s) >= true_k - 1e-9


@pytest.mark.parametrize(
    ("environment", "system", "folder"),
    [
        ({"MUSCLEWIRE_STATE_HOME": "/data/kept", "XDG_STATE_HOME": "/x"}, "linux", Path("/data/kept")),
        ({"XDG_STATE_HOME": "/x"}, "linux", Path("/x/musclewire")),
        ({"XDG_STATE_HOME": "not/absolute"}, "linux", Path.home() / ".local/state/musclewire"),
        ({"XDG_STATE_HOME": ""}, "freebsd14", Path.home() / ".local/state/musclewire"),
        ({"XDG_STATE_HOME": "/x"}, "darwin", Path.home() / "Library/Application Support/musclewire"),
        ({"LOCALAPPDATA": "/users/me/local"}, "win32", Path("/users/me/local/musclewire")),
        ({}, "win32", Path.home() / "AppData/Local/musclewire"),
    ],
)
def test_the_state_folder_is_where_the_system_has_it(environment: dict[str, str], system: str, folder: Path) -> None:
    assert state_folder(environment, system) == folder


def test_tests_keep_nothing_in_the_users_own_folder() -> None:
    assert state_folder().is_relative_to(tempfile.gettempdir())


def test_a_user_without_a_home_folder_is_told_and_begins_cold(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("MUSCLEWIRE_STATE_HOME")
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setattr(Path, "home", nowhere)
    found = opened(BOARD, LIMITS, KeptFile(BOARD), NOW_S)
    assert found.temperature_k == AMBIENT_K
    assert "this user has no home folder" in str(found.reason)


def test_a_file_stays_where_it_was_at_opening(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = KeptFile(BOARD)
    before = kept.path()
    monkeypatch.setenv("MUSCLEWIRE_STATE_HOME", "/elsewhere")
    assert kept.path() == before


@pytest.mark.parametrize(
    "identity",
    ["COM3", "/dev/ttyACM0", "../../etc/passwd", "socket://127.0.0.1:4000", ".", "", "Kraße\0\n", "x" * 999, "\ud800"],
)
def test_every_identity_has_a_file_name_of_its_own_that_every_system_takes(identity: str) -> None:
    name = file_name_of(identity)
    assert name.isascii()
    assert name.replace("-", "").removesuffix(".json").isalnum()
    assert len(name) < 100
    assert name != file_name_of(identity + " ")
    assert name.lower() != file_name_of(identity.swapcase() + "a").lower()


@given(st.floats(200.0, 1500.0), st.floats(0.0, 4e9), st.text())
def test_what_is_written_is_read_as_it_was(temperature_k: float, unix_time_s: float, identity: str) -> None:
    kept = KeptInMemory(text_of(identity, WireTemperature(temperature_k, unix_time_s)))
    found = opened(identity, LIMITS, kept, unix_time_s)
    assert found.known
    assert found.temperature_k == pytest.approx(max(temperature_k, AMBIENT_K))
