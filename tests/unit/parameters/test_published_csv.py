"""The published table as a file for spreadsheets says what the published numbers say."""

from __future__ import annotations

import csv

from musclewire.parameters import read_published
from musclewire.parameters._library import published_text


def test_the_published_table_2_is_the_same_in_both_files() -> None:
    table = read_published("lan_fan_2010")["table2"]
    text = [line for line in published_text("lan-fan-2010-table-2.csv").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(text))
    assert [float(row["Required R [ohm]"]) for row in rows] == table["required_resistance_ohm"]
    assert [float(row["S_h [%]"]) for row in rows] == table["strain_heating_pct"]
    assert [float(row["S_c [%]"]) for row in rows] == table["strain_cooling_pct"]


def test_the_header_of_the_published_csv_repeats_the_loop_it_belongs_to() -> None:
    loop = read_published("lan_fan_2010")["loop_100um"]
    lines = [
        line[1:].split("=", 1) for line in published_text("lan-fan-2010-table-2.csv").splitlines() if line[0] == "#"
    ]
    header = {key.strip(): value.strip() for key, value in lines}
    for key in ("pretension_n", "resistance_min_ohm", "resistance_max_ohm"):
        assert float(header[key]) == loop[key]
