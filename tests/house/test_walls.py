"""What the check of walls finds, on a small house, and that this one passes it."""

from __future__ import annotations

from pathlib import Path

from checks.walls import (
    SOURCES,
    House,
    behind_walls,
    house_in,
    reaches,
    wrong_lists,
)

WIRE = "musclewire.wire"
LISTS = {
    "musclewire": {"Wire": "musclewire.wire"},
    WIRE: {"Wire": "musclewire.wire._row", "simulate": "musclewire.wire._time"},
}


def small_house(**more: str) -> House:
    """A room with a list, a room that uses it, and whatever a test adds."""
    modules = {
        "musclewire": "",
        WIRE: "",
        "musclewire.wire._row": "class Wire: ...",
        "musclewire.wire._time": "from musclewire.wire._row import Wire",
        "musclewire.rigs._own": "from musclewire.wire import simulate",
        **{f"musclewire.{name.replace('__', '._')}": text for name, text in more.items()},
    }
    return House(modules, LISTS)


def test_an_import_behind_anothers_wall_is_found_in_the_package_and_outside() -> None:
    house = small_house(sensing__own="def f():\n    from musclewire.wire._row import Wire\n")
    outside = {
        Path("tests/app/test_a.py"): "from musclewire.wire import _time\n",
        Path("tests/unit/wire/test_b.py"): "from musclewire.wire._time import simulate\n",
        Path("benchmarks/c.py"): "import musclewire.wire._row\n",
    }
    found = behind_walls(house, outside)
    assert [line.partition(" imports ")[0] for line in found] == [
        "src: musclewire.sensing._own:2",
        "tests/app/test_a.py:1",
        "benchmarks/c.py:1",
    ]


def test_a_list_has_what_is_used_and_nothing_else() -> None:
    house = small_house(app__own="from musclewire.wire import shorten")
    assert wrong_lists(house, {}, ()) == ["shorten is taken from musclewire.wire, which does not list it"]
    unused = House(small_house().modules, {**LISTS, WIRE: {**LISTS[WIRE], "idle": "musclewire.wire._row"}})
    assert wrong_lists(unused, {}, ()) == ["musclewire.wire lists idle, which nobody uses: take it off"]
    assert wrong_lists(unused, {}, ("musclewire.wire:idle",)) == []


def test_a_way_to_the_simulator_leads_through_lists_by_the_name_that_is_taken() -> None:
    row = small_house(sensing__own="from musclewire.wire import Wire")
    assert reaches(row, ("musclewire.sensing",), ("musclewire.wire._time",)) == []
    through = small_house(sensing__own="from musclewire.wire import simulate")
    assert reaches(through, ("musclewire.sensing",), ("musclewire.wire._time",)) == [
        "musclewire.sensing._own -> musclewire.wire._time"
    ]


def test_what_runs_on_a_real_wire_is_there_to_be_checked() -> None:
    """A module that has moved would be held to nothing."""
    from checks.walls import ON_A_REAL_WIRE, SIMULATED

    modules = house_in(SOURCES).modules
    for name in (*ON_A_REAL_WIRE, *SIMULATED):
        assert any(module.startswith(name) for module in modules), name
