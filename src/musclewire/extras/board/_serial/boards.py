"""Boards that carry the firmware: the names that people use for them, and the USB devices that they report as."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Any

_TEXT = files("musclewire.extras.board._serial").joinpath("data", "boards.toml").read_text(encoding="utf-8")
# What is known of each board, by its own name.
BOARDS: dict[str, dict[str, Any]] = tomllib.loads(_TEXT)
# A board's own name by each name that people use.
BOARD_NAMES: dict[str, str] = {
    alias: board for board, known in BOARDS.items() for alias in (board, *known["also_called"])
}
# A USB device's board and chip by vendor and product number.
USB_DEVICES: dict[tuple[int, int], tuple[str, str]] = {
    (device["vendor"], device["product"]): (board, device["name"])
    for board, known in BOARDS.items()
    for device in known["usb"]
}
