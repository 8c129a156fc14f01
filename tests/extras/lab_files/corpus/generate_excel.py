"""Write the corpus's workbooks with openpyxl, as people type and instruments export them."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from openpyxl import Workbook
from tests.extras.lab_files.corpus.lab_signals import (
    DISPLACEMENT_MM,
    FORCE_N,
    ROWS,
    SHUNT_VOLTAGE_V,
    TIME_S,
    WIRE_VOLTAGE_V,
)

START = datetime(2024, 3, 8, 10, 30, 28, 500_000)
NUMBERS = list(
    zip(TIME_S.tolist(), WIRE_VOLTAGE_V.tolist(), SHUNT_VOLTAGE_V.tolist(), DISPLACEMENT_MM.tolist(), strict=True)
)
HEADERS = ("Time [s]", "Wire voltage [V]", "Shunt voltage [V]", "LVDT [mm]")


def save(path: Path, sheets: dict[str, Iterable[Iterable[Any]]]) -> None:
    """Write rows of cells as sheets."""
    workbook = Workbook()
    workbook.remove(workbook.active)
    for name, rows in sheets.items():
        sheet = workbook.create_sheet(name)
        for row in rows:
            sheet.append(list(row))
    workbook.save(path)


def good(folder: Path) -> None:
    """Write files that are read, and some that are refused with the cure."""
    save(folder / "xlsx_plain.xlsx", {"Sheet1": [HEADERS, *NUMBERS]})
    titles = [("SMA wire 0.1 mm, run 3",), (), ("Shunt resistance", 0.47, "ohm"), ("Operator:", "lab"), ()]
    units = ("s", "V", "V", "mm")
    names = ("Zeit", "U wire", "U shunt", "Weg")
    save(folder / "xlsx_titles_and_units.xlsx", {"Messung": [*titles, names, units, *NUMBERS]})
    save(folder / "xlsx_units_in_brackets.xlsx", {"A": [names, tuple(f"[{unit}]" for unit in units), *NUMBERS]})
    save(folder / "xlsx_notes_sheet.xlsx", {"Notes": [("Wire broke on Tuesday",)], "Data": [HEADERS, *NUMBERS]})
    forces = list(zip(TIME_S.tolist(), FORCE_N.tolist(), strict=True))
    save(
        folder / "xlsx_two_sheets.xlsx",
        {"Electrical": [HEADERS, *NUMBERS], "Force": [("Time [s]", "Force [N]"), *forces]},
    )
    dates = [(START + timedelta(seconds=row[0]), *row[1:]) for row in NUMBERS]
    save(folder / "xlsx_dates.xlsx", {"Log": [("Timestamp", *HEADERS[1:]), *dates]})
    texts = [(f"2024-03-08T10:30:{28 + row[0]:06.3f}", *row[1:]) for row in NUMBERS if 28 + row[0] < 31]
    save(folder / "xlsx_dates_as_text.xlsx", {"Log": [("Timestamp", *HEADERS[1:]), *texts]})
    spare = [("", *row, None, "ok" if number == 4 else None) for number, row in enumerate(NUMBERS)]
    save(folder / "xlsx_empty_columns.xlsx", {"Log": [("", *HEADERS, None, "Comment"), *spare]})
    formulas = [(f"=A{number + 1}+0.05" if number > 1 else 0.0, *row[1:]) for number, row in enumerate(NUMBERS, 1)]
    save(folder / "xlsx_time_never_calculated.xlsx", {"Log": [HEADERS, *formulas]})
    all_formulas = [("=ROW()*0.05", "=A2*2") for _ in range(ROWS)]
    save(folder / "xlsx_never_calculated.xlsx", {"Log": [HEADERS[:2], *all_formulas]})
    numbers_as_text = [tuple(str(value).replace(".", ",") for value in row) for row in NUMBERS]
    save(folder / "xlsx_numbers_as_text.xlsx", {"Log": [HEADERS, *numbers_as_text]})


def repacked(path: Path, source: Path, changes: dict[str, bytes]) -> None:
    """Write a workbook whose members are replaced."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as new:
        for member in old.namelist():
            new.writestr(member, changes.get(member, old.read(member)))
        for member, content in changes.items():
            if member not in old.namelist():
                new.writestr(member, content)


def damaged(folder: Path, good_folder: Path) -> None:
    """Write files that are refused."""
    plain = good_folder / "xlsx_plain.xlsx"
    whole = plain.read_bytes()
    (folder / "xlsx_cut_off.xlsx").write_bytes(whole[: len(whole) // 2])
    (folder / "xlsx_old_or_encrypted.xlsx").write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + b"\0" * 600)
    (folder / "xlsx_old.xls").write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + b"\0" * 600)
    with zipfile.ZipFile(folder / "xlsx_other_zip.xlsx", "w") as other:
        other.writestr("readme.txt", "no workbook")
    sheet = "xl/worksheets/sheet1.xml"
    with zipfile.ZipFile(plain) as workbook:
        content = workbook.read(sheet)
    # The first number is an entity of the document type.
    named = content.replace(b"<v>0</v>", b"<v>&j;</v>", 1)
    entities = b'<?xml version="1.0"?><!DOCTYPE z [<!ENTITY a "aaaaaaaaaa">' + b"".join(
        f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">'.encode() for i in range(9)
    )
    repacked(folder / "xlsx_entities.xlsx", plain, {sheet: entities + b"]>" + named})
    outside = b'<?xml version="1.0"?><!DOCTYPE z [<!ENTITY j SYSTEM "file:///etc/passwd">]>' + named
    repacked(folder / "xlsx_entity_of_a_file.xlsx", plain, {sheet: outside})
    repacked(folder / "xlsx_row_too_high.xlsx", plain, {sheet: content.replace(b'<row r="2"', b'<row r="999999999"')})
    repacked(folder / "xlsx_xml_cut.xlsx", plain, {sheet: content[: len(content) // 2]})
    repacked(folder / "xlsx_sheet_missing.xlsx", plain, {"xl/_rels/workbook.xml.rels": b"<Relationships/>"})
