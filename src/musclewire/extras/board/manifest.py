"""Boards and cards that drive a real wire, and the controller in C for them."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

MANIFEST = Manifest(
    name="board",
    commands=(
        Command(
            "flash",
            "musclewire.extras.board._flash_command:flash",
            "Put the built firmware for a wire on a board, and ask the board whether it runs.",
            answer="musclewire.extras.board._flash_command:FlashAnswer",
            panel="A wire on a bench",
            before="doctor",
        ),
        Command(
            "c",
            "musclewire.extras.board._export_c_command:export_c",
            "Model, controller, limits and protection as a self-contained C99 library, with its own test vectors.",
            group="export",
            answer="musclewire.extras.board._export_c_command:ExportCAnswer",
        ),
        Command(
            "micropython",
            "musclewire.extras.board._export_micropython_command:export_micropython",
            "The program of a board with MicroPython, for one wire in one circuit: copy its files to the board.",
            group="export",
            answer="musclewire.extras.board._export_micropython_command:ExportMicropythonAnswer",
        ),
    ),
    devices={
        "nidaq": "musclewire.extras.board._nidaq.device:NIDAQ",
        "serial": "musclewire.extras.board._serial.device:SERIAL",
    },
    needs={"nidaq": "nidaq"},
    rig_files="musclewire.extras.board:rig_files",
    rig_names={
        "uno": "arduino-uno",
        "nano": "arduino-uno",
        "arduino-nano": "arduino-uno",
        "uno-r3": "arduino-uno",
        "black-pill": "stm32f411",
        "blackpill": "stm32f411",
    },
    versions={"firmware_protocol": "musclewire.extras.board._serial.message_types:PROTOCOL_VERSION"},
)
