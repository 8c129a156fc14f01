"""What this package adds to musclewire. Only words: what they name is imported when it is used."""

from musclewire import Command, Manifest

MANIFEST = Manifest(
    name="wire-logs",
    commands=(
        Command("ohms", "wire_logs.adds:ohms", "Print the resistance in each row of a .wirelog.", panel="Wire logs"),
    ),
    devices={"resistor": "wire_logs.adds:RESISTOR"},
    readers=("wire_logs.adds:reader",),
    suffixes_read=(".wirelog",),
)
