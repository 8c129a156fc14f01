"""Checks an Excel workbook before openpyxl reads it: a real one, not larger unpacked than is read, no document type.

A zip file of a few kilobytes can unpack to terabytes, and an XML document type can expand entities without end or name
other files.
"""

from __future__ import annotations

import zipfile
from pathlib import Path

from musclewire.errors import RecordingError

__all__ = ["check_xlsx"]

MAX_SHEET_BYTES = 2**30
# openpyxl keeps all shared texts, styles and relations in memory; sheets it reads row by row.
MAX_OTHER_BYTES = 2**26
MAX_MEMBERS = 10_000
_PIECE = 2**20
_OLE = b"\xd0\xcf\x11\xe0"


def check_xlsx(path: Path) -> None:
    """Raise RecordingError if a file is no workbook that can be read in bounded memory."""
    with path.open("rb") as file:
        start = file.read(4)
    if start == _OLE:
        cure = "save it as .xlsx, without a password"
        raise RecordingError(f"{path}: is an old .xls workbook or has a password; {cure}")
    if not zipfile.is_zipfile(path):
        raise RecordingError(f"{path}: is no .xlsx workbook, or cut off; save it again in Excel, or as CSV")
    with zipfile.ZipFile(path) as workbook:
        members = workbook.infolist()
        if len(members) > MAX_MEMBERS or "[Content_Types].xml" not in workbook.namelist():
            raise RecordingError(f"{path}: is a zip file but no .xlsx workbook; save it in Excel as .xlsx or CSV")
        for member in members:
            if member.filename.lower().endswith((".xml", ".rels")):
                _check_member(workbook, member, path)


def _check_member(workbook: zipfile.ZipFile, member: zipfile.ZipInfo, path: Path) -> None:
    """Unpack a member in pieces, counting: the size that a zip file states need not be true."""
    is_sheet = "worksheets/" in member.filename
    largest, size, tail = MAX_SHEET_BYTES if is_sheet else MAX_OTHER_BYTES, 0, b""
    with workbook.open(member) as stream:
        while piece := stream.read(_PIECE):
            size += len(piece)
            if size > largest:
                limit = f"unpacks to more than {largest // 2**20} MiB"
                raise RecordingError(f"{path}: '{member.filename}' {limit}; save the sheet as CSV")
            # Without zeros UTF-16 reads like ASCII, so that no encoding hides the word.
            text = (tail + piece).replace(b"\0", b"")
            if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
                raise RecordingError(
                    f"{path}: '{member.filename}' declares a document type, which no workbook has; save it again in "
                    "Excel"
                )
            tail = piece[-32:]
