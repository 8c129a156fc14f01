"""The reference pages list what the code has: columns, settings, keys, symbols, rule bases, error messages."""

from __future__ import annotations

import re

import pytest
from tests.house.docs.doc_pages import code_words, tables_of
from tests.places import CHECKOUT

from musclewire.parameters import load_bench, load_wire
from musclewire.sensing import ModelFile
from musclewire.signals import COLUMNS

DOCS = CHECKOUT / "docs"


def rows_with(header: str, page: str = "reference/files.md") -> list[dict[str, str]]:
    """Return the rows of a page that have a header."""
    tables = tables_of((DOCS / page).read_text("utf-8"))
    return [row for table in tables for row in table if header in row]


def column_of(page: str, header: str) -> list[str]:
    return [word for row in rows_with(header, page) for word in code_words(row[header])]


def test_every_column_is_listed_with_its_unit_and_no_other() -> None:
    assert sorted(column_of("reference/files.md", "Column")) == sorted(COLUMNS)
    for row in rows_with("Column"):
        for name, unit in zip(code_words(row["Column"]), row.get("Unit", "").split(", "), strict=False):
            if not name.endswith("_gain"):
                assert (COLUMNS[name].unit or "1") == unit


def test_every_key_of_model_files_is_listed() -> None:
    assert set(column_of("reference/files.md", "Key")) == set(ModelFile.model_fields)


def test_every_error_message_explained_is_one_that_the_code_says() -> None:
    source = "".join(path.read_text("utf-8") for path in sorted((CHECKOUT / "src/musclewire").rglob("*.py")))
    joined = re.sub(r'"\s*\n\s*f?"', "", source)
    explained = column_of("how-to/read_my_recordings.md", "Message")
    assert len(explained) > 10
    assert [text for text in explained if text not in joined] == []


@pytest.mark.parametrize(
    ("diameter_um", "resistance_ohm_per_m", "maximum_n", "nominal_n"),
    [(100, 126.0, 4.601, 0.275), (125, 75.0, 7.220, 0.422), (200, 29.0, 18.247, 1.079)],
)
def test_table_1_is_in_the_wire_files_as_printed(
    diameter_um: int, resistance_ohm_per_m: float, maximum_n: float, nominal_n: float
) -> None:
    values = load_wire(f"paper-{diameter_um}um").values()
    assert values["diameter_m"] == pytest.approx(diameter_um * 1e-6, rel=1e-12)
    assert values["resistance_per_metre_ohm_per_m"] == resistance_ohm_per_m
    assert (values["maximum_force_n"], values["nominal_force_n"]) == (maximum_n, nominal_n)


def test_the_bench_has_the_spring_and_the_length_of_the_paper() -> None:
    bench = load_bench("paper").values()
    assert (bench["spring_stiffness_n_per_m"], bench["wire_length_m"], bench["legs"]) == (588.60, 0.14, 2)
    assert bench["sample_period_s"] == 0.05
