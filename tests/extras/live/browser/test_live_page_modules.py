"""The live page's modules without a page: rings, envelopes, formats, paths, fields. A Chromium runs them."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.browser

FOLDER = Path(str(files("musclewire.extras.live"))) / "page"
TYPES = {".js": "text/javascript", ".html": "text/html"}


@pytest.fixture(scope="module")
def modules(browser: Any) -> Iterator[Any]:
    """A page of nothing, from whose address the modules can be imported."""

    def answer(route: Any) -> None:
        path = FOLDER / route.request.url.removeprefix("http://page.test/")
        if path.is_file():
            route.fulfill(body=path.read_text("utf-8"), content_type=TYPES[path.suffix])
        else:
            route.fulfill(body="<!doctype html>", content_type="text/html")

    page = browser.new_page()
    page.route("**/*", answer)
    page.goto("http://page.test/")
    yield page
    page.close()


def run(modules: Any, name: str, body: str) -> Any:
    """Return what a function body gives that uses a module as ``m``."""
    return modules.evaluate(f"async () => {{ const m = await import('/{name}.js'); {body} }}")


def test_a_ring_keeps_the_last_rows_and_never_twice_its_capacity(modules: Any) -> None:
    body = """const rows = new m.LastRows(2, 100); let longest = 0;
        for (let n = 0; n < 10000; n += 1) { rows.push([n, -n]); longest = Math.max(longest, rows.length); }
        const time = rows.column(0);
        return [longest, rows.last(0), time[0], time.every((each, n) => n === 0 || each === time[n - 1] + 1)];"""
    longest, last, first, is_whole = run(modules, "ring_buffers", body)
    assert longest <= 200
    assert last == 9999
    assert last - first + 1 >= 100
    assert is_whole


def test_a_missing_value_is_a_gap_and_not_a_number(modules: Any) -> None:
    body = """const rows = new m.LastRows(2, 3); const nothing = rows.last(1);
        for (const row of [[0, 5], [1, null], [2, 0], [3, undefined]]) rows.push(row);
        return [nothing, rows.column(1), rows.column(1, 2), rows.value(1, 4), rows.firstFrom(1.5)];"""
    assert run(modules, "ring_buffers", body) == [None, [5, None, 0, None], [0, None], None, 2]


def test_an_envelope_loses_no_peak(modules: Any) -> None:
    body = """const all = new m.Envelope(2, 1000, 1.0);
        for (let n = 0; n < 3000; n += 1) all.push([n / 100, n === 1234 ? 50 : n === 1250 ? -7 : 1]);
        return [Math.max(...all.rows.column(1)), Math.min(...all.rows.column(1)), all.rows.length];"""
    assert run(modules, "ring_buffers", body) == [50, -7, 58]


def test_a_history_begins_again_when_the_clock_of_the_rig_does(modules: Any) -> None:
    body = "const h = new m.History(1); h.push([5]); h.push([6]); h.push([0.05]); return h.recent.column(0);"
    assert run(modules, "ring_buffers", body) == [0.05]


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        ("m.fixed(null, 2)", "–"),
        ("m.fixed(-0.001, 2)", "0.00"),
        ("m.namedValue('maximum_temperature_k', 473.15).join(' ')", "Maximum temperature 200\u202f°C"),
        ("m.span(125)", "2\u202fmin 05\u202fs"),
        ("m.ticks(0, 1, 5).map((each) => each.toFixed(1)).join(' ')", "0.0 0.2 0.4 0.6 0.8 1.0"),
    ],
)
def test_numbers_are_written_for_people(modules: Any, expression: str, text: str) -> None:
    assert run(modules, "format", f"return {expression};") == text


def test_rows_have_the_units_that_are_shown_and_no_resistance_without_current(modules: Any) -> None:
    body = """
        const names = ["time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m", "protection_temperature_k"];
        const rig = { leg_length_m: 0.07, shunt_resistance_ohm: 2.0, minimum_current_a: 0.001 };
        const read = m.rowReader(names, { quantity: "strain", ...rig });
        const shown = ["current", "resistance", "power", "instrument", "temperature"];
        const of = (row) => shown.map((each) => row[m.COLUMN[each]]);
        return [of(read([1, 3.0, 0.4, 0.0014, 373.15])), of(read([1, 3.0, 0.0001, null, null]))];"""
    driven, without = run(modules, "rows", body)
    assert driven == pytest.approx([200.0, 15.0, 600.0, 2.0, 100.0])
    assert without[0] == pytest.approx(0.05)
    assert without[1:] == [None, None, None, None]


def test_a_drawn_path_goes_on_in_time_from_0_to_its_duration(modules: Any) -> None:
    body = "return m.asPath([[3, 1], [1, 2], [1.0005, 4], [9, 5]], 6);"
    assert run(modules, "path_editor", body) == [[0, 4], [1, 4], [3, 1], [6, 5]]


@pytest.mark.parametrize(
    ("field", "text", "expected"),
    [
        ("{label: 'Hold', unit: 's', min: 0.5}", "6,5", 6.5),
        ("{label: 'Voltage', unit: 'V', optional: true}", " ", None),
        ("{label: 'Pretensions', text: true}", "1.2 1,5", [1.2, 1.5]),
        ("{label: 'Hold', unit: 's', min: 0.5}", "0.1", "Hold: at least 0.5 s."),
        ("{label: 'Cycles', whole: true}", "1.5", "Cycles: write a whole number."),
        ("{label: 'Hold', unit: 's'}", "long", "Hold: write a number."),
    ],
)
def test_fields_give_numbers_or_say_what_is_wrong(modules: Any, field: str, text: str, expected: Any) -> None:
    body = f"try {{ return m.readField({field}, {text!r}); }} catch (problem) {{ return problem.message; }}"
    assert run(modules, "run_kinds", body) == expected


STEERING = """
    const made = (kind) => document.createElement(kind);
    const parts = { slider: made("input"), "slider-number": made("input"), steer: made("button") };
    const said = [], refused = [], answers = [];
    const send = (value) => new Promise((resolve) => { said.push(value); answers.push(resolve); });
    const steering = new m.Steering(parts, { send, start: () => {}, refuse: (text) => refused.push(text) });
    steering.canSteer = true;
    steering.scale = { lowest: 0, highest: 100, unit: "%", digits: 2, factor: 1 };
    const later = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
"""


def test_the_last_value_of_a_slider_arrives_however_late_answers_come(modules: Any) -> None:
    body = """for (let value = 1; value <= 60; value += 1) { steering.moved(value); await later(5); }
        answers.shift()({ accepted: true }); await later(100);
        return [said, answers.length];"""
    assert run(modules, "steering", STEERING + body) == [[1, 60], 1]


def test_a_slider_whose_value_was_refused_shows_the_target_of_the_loop(modules: Any) -> None:
    body = """steering.moved(7); answers.shift()({ accepted: false, message: "no" }); await later(0);
        steering.followRow(3.25);
        return [refused, parts["slider-number"].value];"""
    assert run(modules, "steering", STEERING + body) == [["", "no"], "3.25"]


def test_a_refusal_that_a_newer_value_has_overtaken_is_not_shown(modules: Any) -> None:
    body = """steering.moved(7); steering.moved(8); answers.shift()({ accepted: false, message: "no" }); await later(0);
        steering.followRow(3.25); await later(100); answers.shift()({ accepted: true }); await later(100);
        return [said, refused.at(-1), parts["slider-number"].value];"""
    assert run(modules, "steering", STEERING + body) == [[7, 8], "", "8.00"]


def test_a_value_that_could_not_be_sent_stops_no_later_one(modules: Any) -> None:
    body = """let broken = true;
        steering.send = (value) => (broken ? Promise.reject(new Error("gone")) : send(value));
        steering.moved(7); await later(100); broken = false; steering.moved(9); await later(100);
        return [said, refused.filter((text) => text.includes("gone")).length];"""
    assert run(modules, "steering", STEERING + body) == [[9], 1]
