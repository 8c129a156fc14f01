"""How warm a wire counts at opening by what was kept of it; texts in memory, clocks that a test sets."""

from __future__ import annotations

import json
import tempfile
from math import inf, nan
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.unit.rigs.remembered_wire import AMBIENT_K, BOARD, LIMIT_K, LIMITS, NOW, REST_S, later

from musclewire.errors import CallerError
from musclewire.rigs import state_folder
from musclewire.rigs._remembered_temperature import (
    AHEAD_S,
    SLEEP_S,
    KeptFile,
    Moment,
    RememberedTemperature,
    TemperatureKeeper,
    WireTemperature,
    cooled_k,
    file_name_of,
    opened,
    rest_s,
    text_of,
    this_moment,
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
        return WireTemperature(kept["temperature_k"], Moment(kept["boot"], kept["awake_s"], kept["asleep_s"]))


def kept_at(temperature_k: float, before_s: float) -> KeptInMemory:
    return KeptInMemory(text_of(BOARD, WireTemperature(temperature_k, later(-before_s))))


def test_a_device_without_an_identity_begins_cold_and_keeps_nothing() -> None:
    kept = KeptInMemory()
    remembered = RememberedTemperature(None, LIMITS, kept=kept)
    assert remembered.at_opening == (AMBIENT_K, 0.0, None)
    remembered.note(400.0)
    remembered.close()
    remembered.close()
    assert kept.texts == [None]


def test_a_device_of_which_nothing_is_kept_counts_as_its_limit_and_rests() -> None:
    """It may be at another port, of another user, or under another rig file, and hot."""
    found = opened(BOARD, LIMITS, KeptInMemory(), NOW)
    assert (found.temperature_k, found.rest_s) == (LIMIT_K, pytest.approx(REST_S))
    assert "it is opened for the first time" in str(found.reason)


@pytest.mark.parametrize(("seconds", "known"), [(0.0, True), (2.9, True), (REST_S, False), (9e9, False)])
def test_what_is_known_is_known_for_no_longer_than_others_rest_who_know_nothing(seconds: float, known: bool) -> None:
    found = opened(BOARD, LIMITS, kept_at(AMBIENT_K, seconds), NOW)
    assert (found.rest_s == 0.0) is known
    assert found.temperature_k == (AMBIENT_K if known else LIMIT_K)
    assert known or "others may have heated it since" in str(found.reason)


@pytest.mark.parametrize("stated_k", [250.0, AMBIENT_K, 310.0])
def test_a_stated_temperature_takes_the_place_of_the_rest_and_of_nothing_that_is_known(stated_k: float) -> None:
    counted = max(stated_k, AMBIENT_K)
    found = opened(BOARD, LIMITS, KeptInMemory(), NOW, stated_k)
    assert (found.temperature_k, found.rest_s) == (counted, 0.0)
    assert f"it counts as {counted - 273.15:.0f} C, as stated" in str(found.reason)
    assert opened(BOARD, LIMITS, kept_at(410.0, 0.0), NOW, stated_k) == (pytest.approx(410.0), 0.0, None)
    new = RememberedTemperature(None, LIMITS, stated_k=stated_k, kept=KeptInMemory()).at_opening
    assert new == (counted, 0.0, None)


def test_a_wire_that_its_largest_drive_leaves_below_the_limit_never_rests() -> None:
    harmless = LIMITS._replace(maximum_voltage_v=1.0)
    found = opened(BOARD, harmless, KeptInMemory(), None)
    settled_k = AMBIENT_K + 10.0 / 11.0**2 / LIMITS.heat_loss_w_per_k
    assert found == (pytest.approx(settled_k), 0.0, None)
    assert rest_s(harmless) == 0.0


@pytest.mark.parametrize(("passed", "left"), [(0.0, 1.0), (1.0, 0.36788), (2.0, 0.13534), (3.0, 0.04979)])
def test_a_wire_cools_by_its_limits_heat_balance_over_the_time_passed(passed: float, left: float) -> None:
    found = opened(BOARD, LIMITS, kept_at(AMBIENT_K + 100.0, passed * TIME_CONSTANT_S), NOW)
    assert found.temperature_k == pytest.approx(AMBIENT_K + 100.0 * left, abs=1e-3)
    assert (found.rest_s, found.reason) == (0.0, None)


@pytest.mark.parametrize("ahead_s", [0.0, 1.0, AHEAD_S])
def test_what_was_kept_ahead_of_a_kill_counts_as_no_time_passed(ahead_s: float) -> None:
    found = opened(BOARD, LIMITS, kept_at(410.0, -ahead_s), NOW)
    assert (found.temperature_k, found.rest_s) == (pytest.approx(410.0), 0.0)


@pytest.mark.parametrize(
    ("now", "why"),
    [
        (NOW._replace(boot="another start"), "started again"),
        (NOW._replace(awake_s=NOW.awake_s - AHEAD_S - 0.1), "started again"),
        (NOW._replace(asleep_s=SLEEP_S + 0.1), "has slept"),
        (None, "does not say when it was started"),
    ],
)
def test_of_another_start_a_sleep_or_a_system_without_a_start_nothing_is_known(now: Moment | None, why: str) -> None:
    """However long ago it seems, and however cold the wire was: it counts as its limit and rests."""
    found = opened(BOARD, LIMITS, kept_at(AMBIENT_K, 0.0), now)
    assert (found.temperature_k, found.rest_s) == (LIMIT_K, pytest.approx(REST_S))
    assert why in str(found.reason)
    assert "rests at its sense voltage for 4.5 s before it is heated" in str(found.reason)


def test_a_sleep_that_was_over_when_it_was_kept_is_none_since() -> None:
    slept = NOW._replace(asleep_s=900.0)
    kept = KeptInMemory(text_of(BOARD, WireTemperature(400.0, slept)))
    assert opened(BOARD, LIMITS, kept, slept).rest_s == 0.0


@given(st.floats(AMBIENT_K, 1500.0))
def test_a_wire_that_has_rested_is_cold_however_warm_it_was(temperature_k: float) -> None:
    left_k = cooled_k(WireTemperature(temperature_k, NOW), LIMITS, later(REST_S)) - AMBIENT_K
    assert left_k <= 0.00674 * (temperature_k - AMBIENT_K) + 1e-9


def test_this_machine_has_one_start_and_a_clock_that_goes_on() -> None:
    first, second = this_moment(), this_moment("given")
    assert first is not None
    assert second is not None
    assert (len(first.boot), second.boot) == (36, "given")
    assert 0.0 <= second.awake_s - first.awake_s < 60.0
    assert abs(second.asleep_s - first.asleep_s) < SLEEP_S


def test_a_system_without_a_start_has_no_moment_and_nothing_is_kept_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("musclewire.rigs._remembered_temperature.BOOT_ID", tmp_path / "none")
    assert this_moment() is None
    kept = KeptInMemory()
    remembered = RememberedTemperature(BOARD, LIMITS, kept=kept)
    remembered.note(400.0)
    remembered.close()
    assert (kept.texts, remembered.at_opening.rest_s) == ([None], pytest.approx(REST_S))


def test_a_wire_that_was_colder_than_the_air_counts_as_the_air_and_one_above_the_limit_as_it_was() -> None:
    assert opened(BOARD, LIMITS, kept_at(250.0, 0.0), NOW).temperature_k == AMBIENT_K
    assert opened(BOARD, LIMITS, kept_at(LIMIT_K + 30.0, 0.0), NOW).temperature_k == pytest.approx(LIMIT_K + 30.0)


def with_numbers(temperature_k: object, awake_s: object, identity: object = BOARD) -> str:
    moment = {"boot": NOW.boot, "awake_s": awake_s, "asleep_s": 0.0}
    return json.dumps({"identity": identity, "temperature_k": temperature_k, **moment})


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
        with_numbers(nan, NOW.awake_s),
        with_numbers(inf, NOW.awake_s),
        with_numbers(-3.0, NOW.awake_s),
        with_numbers(0.0, NOW.awake_s),
        with_numbers(5000.0, NOW.awake_s),
        with_numbers(None, NOW.awake_s),
        with_numbers("warm", NOW.awake_s),
        with_numbers(10**400, NOW.awake_s),
        with_numbers(400.0, nan),
        with_numbers(400.0, None),
        with_numbers(400.0, NOW.awake_s, "another board"),
        with_numbers(400.0, NOW.awake_s, None),
        json.dumps({"identity": BOARD, "temperature_k": 300.0, "unix_time_s": 1.8e9}),  # as older versions wrote
        text_of(BOARD, WireTemperature(400.0, NOW))[:40],
    ],
)
def test_a_text_that_makes_no_sense_counts_as_the_limit_and_is_said(text: str) -> None:
    kept = KeptInMemory(text)
    found = opened(BOARD, LIMITS, kept, NOW)
    assert (found.temperature_k, found.rest_s) == (LIMIT_K, pytest.approx(REST_S))
    assert found.reason is not None
    assert found.reason.startswith("how warm the wire is is not known (kept.json cannot be read: ")
    assert "it rests at its sense voltage for 4.5 s before it is heated, unless you state it" in found.reason
    assert "\n" not in found.reason
    assert kept.stored == (LIMIT_K, NOW)


@given(st.text())
def test_any_text_gives_a_temperature_between_air_and_melting(text: str) -> None:
    assert AMBIENT_K <= opened(BOARD, LIMITS, KeptInMemory(text), NOW).temperature_k < 1583.0


def test_limits_without_a_highest_temperature_leave_what_the_largest_drive_makes_of_the_wire() -> None:
    limits = LIMITS._replace(maximum_temperature_k=inf)
    found = opened(BOARD, limits, KeptInMemory("?"), NOW)
    assert found[:2] == (pytest.approx(AMBIENT_K + 3.6**2 * 10.0 / 11.0**2 / LIMITS.heat_loss_w_per_k), 0.0)


def test_a_file_of_somebody_else_that_may_not_be_read_counts_as_the_limit() -> None:
    kept = kept_at(300.0, 0.0)
    kept.reading = PermissionError(13, "Permission denied")
    found = opened(BOARD, LIMITS, kept, NOW)
    assert (found.temperature_k, found.rest_s) == (LIMIT_K, pytest.approx(REST_S))
    assert "Permission denied" in str(found.reason)


@pytest.mark.parametrize("error", [PermissionError(13, "Permission\ndenied"), CallerError("folder: cannot be written")])
def test_a_folder_that_cannot_be_written_is_said_at_opening_and_raises_nothing_later(error: Exception) -> None:
    kept = kept_at(400.0, 0.0)
    kept.writing = error
    remembered = RememberedTemperature(BOARD, LIMITS, kept=kept, clock=lambda: NOW)
    found = remembered.at_opening
    assert (found.temperature_k, found.rest_s) == (pytest.approx(400.0), 0.0)
    assert str(found.reason).startswith("kept.json: how warm the wire is cannot be kept (")
    assert "MUSCLEWIRE_STATE_HOME" in str(found.reason)
    assert "\n" not in str(found.reason)
    remembered.note(420.0)
    remembered.close()
    assert len(kept.texts) == 1


def test_closing_keeps_what_was_noted_last_at_the_time_of_its_note() -> None:
    kept, times = KeptInMemory(), iter([NOW, later(1.0), later(2.0), later(99.0)])
    remembered = RememberedTemperature(BOARD, LIMITS, kept=kept, clock=lambda: next(times))
    remembered.note(390.0)
    remembered.note(380.0)
    remembered.close()
    assert kept.stored == (380.0, later(2.0))
    assert set(json.loads(str(kept.text))) == {"identity", "temperature_k", "boot", "awake_s", "asleep_s"}
    remembered.note(450.0)
    remembered.close()
    assert kept.stored == (380.0, later(2.0))


def test_a_rig_that_never_exchanges_leaves_what_it_found_cooled_until_its_opening() -> None:
    kept = kept_at(AMBIENT_K + 100.0, TIME_CONSTANT_S)
    RememberedTemperature(BOARD, LIMITS, kept=kept, clock=lambda: NOW).close()
    assert kept.stored == (pytest.approx(AMBIENT_K + 36.788, abs=1e-3), NOW)


def test_it_writes_once_a_second_at_most_and_only_what_is_new() -> None:
    kept, seconds = KeptInMemory(), [0.0]
    keeper = TemperatureKeeper(BOARD, LIMITS, kept, elapsed_s=lambda: seconds[0])
    keeper.write_if_due()
    assert kept.texts == [None]
    for tenth in range(31):  # 20 notes a second, a look every 0.1 s
        seconds[0] = tenth / 10
        keeper.noted = WireTemperature(300.0 + tenth, later(seconds[0]))
        keeper.write_if_due()
    assert len(kept.texts) - 1 == 4  # at 0, 1, 2 and 3 s
    seconds[0] = 50.0
    keeper.write_if_due()
    assert len(kept.texts) - 1 == 4


def test_while_it_runs_it_keeps_what_the_largest_drive_can_make_of_the_wire_until_the_next_time() -> None:
    kept = KeptInMemory()
    keeper = TemperatureKeeper(BOARD, LIMITS, kept, elapsed_s=lambda: 0.0)
    keeper.noted = WireTemperature(AMBIENT_K, NOW)
    keeper.write_if_due()
    assert kept.stored == (warmest_k(AMBIENT_K, LIMITS, AHEAD_S), later(AHEAD_S))
    keeper.write_last()
    assert kept.stored == (AMBIENT_K, NOW)


def test_an_error_of_the_folder_ends_no_thread_and_the_next_second_writes_again() -> None:
    kept, seconds = KeptInMemory(), [0.0]
    keeper = TemperatureKeeper(BOARD, LIMITS, kept, elapsed_s=lambda: seconds[0])
    keeper.noted, kept.writing = WireTemperature(400.0, NOW), OSError(28, "No space left on device")
    keeper.write_if_due()
    keeper.write_last()
    keeper.noted, kept.writing, seconds[0] = WireTemperature(401.0, NOW), None, 1.0
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
    stored = WireTemperature(warmest_k(begin_k, LIMITS, AHEAD_S), later(AHEAD_S))
    temperature_k, dt_s = begin_k, AHEAD_S / len(drive_v)
    for voltage_v in drive_v:  # each for a while, in closed form; the protection ends it at the limit
        settled_k = AMBIENT_K + (voltage_v / (ohm + 1.0)) ** 2 * ohm / LIMITS.heat_loss_w_per_k
        after_k = settled_k + (temperature_k - settled_k) * 2.718281828459045 ** (-dt_s / TIME_CONSTANT_S)
        temperature_k = min(after_k, LIMIT_K)
    true_k = cooled_k(WireTemperature(temperature_k, later(AHEAD_S)), LIMITS, later(AHEAD_S + opened_after_s))
    assert cooled_k(stored, LIMITS, later(AHEAD_S + opened_after_s)) >= true_k - 1e-9


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


def test_a_user_without_a_home_folder_is_told_and_waits_at_each_opening(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("MUSCLEWIRE_STATE_HOME")
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setattr(Path, "home", nowhere)
    found = opened(BOARD, LIMITS, KeptFile(BOARD), NOW)
    assert (found.temperature_k, found.rest_s) == (LIMIT_K, pytest.approx(REST_S))
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


@given(st.floats(200.0, 1500.0), st.floats(0.0, 4e9), st.text(), st.text())
def test_what_is_written_is_read_as_it_was(temperature_k: float, awake_s: float, identity: str, boot: str) -> None:
    moment = Moment(boot, awake_s, 0.0)
    found = opened(identity, LIMITS, KeptInMemory(text_of(identity, WireTemperature(temperature_k, moment))), moment)
    assert found.rest_s == 0.0
    assert found.temperature_k == pytest.approx(max(temperature_k, AMBIENT_K))
