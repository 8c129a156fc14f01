"""Write the schematic from the parts list: each part where placement.toml has it, each pin with its net's label."""

from __future__ import annotations

import uuid
from pathlib import Path
from typing import Any

from s_expressions import Quoted, Tree, children, first, load

__all__ = ["identity", "reference", "schematic"]

SYMBOLS = Path("/usr/share/kicad/symbols")
FLAGGED = ("GND", "+12V", "+5V_U2")  # nets that a connector, a switch or a fuse supplies: KiCad must be told
# Where a part's name stands, right and down of its middle in mm, by its label or by the first letter of it.
WORDS = {"J": (5.08, -1.27), "T": (8.89, -1.27), "M": (-12.7, -30.48), "U": (3.81, 6.35), "D": (-2.54, 3.81)}
Q = Quoted


def identity(*words: object) -> Quoted:
    """Return an identity that is the same each time."""
    return Q(str(uuid.uuid5(uuid.NAMESPACE_URL, "musclewire/" + "/".join(map(str, words)))))


def reference(label: str) -> str:
    """Return a part's label as KiCad takes it, with a number at its end: RCL1 for RCL."""
    return label if label[-1].isdigit() else f"{label}1"


def library_symbol(name: str) -> Tree:
    """Return a symbol of KiCad's libraries under its full name, with what it inherits."""
    library, _, short = name.partition(":")
    symbols = {str(item[1]): item for item in children(load(SYMBOLS / f"{library}.kicad_sym"), "symbol")}
    own = symbols[short]
    chain = [own]
    while parents := children(chain[-1], "extends"):
        chain.append(symbols[str(parents[0][1])])
    whole = [item for item in chain[-1] if not (isinstance(item, list) and item[0] == "property")]
    base = str(whole[1])
    for item in children(whole, "symbol"):
        item[1] = Q(short + str(item[1])[len(base) :])
    kept: dict[str, Tree] = {}
    for ancestor in reversed(chain):
        kept |= {str(item[1]): item for item in children(ancestor, "property")}
    return [*whole[:1], Q(name), *kept.values(), *whole[2:]]


def pins_of(symbol: Tree) -> dict[str, tuple[int, float, float, int]]:
    """Return unit, place and direction of each pin by its number."""
    found = {}
    for unit in children(symbol, "symbol"):
        number = int(str(unit[1]).rsplit("_", 2)[1])
        for pin in children(unit, "pin"):
            x, y, angle = (float(str(word)) for word in first(pin, "at")[1:4])
            found[str(first(pin, "number")[1])] = (number, x, y, int(angle))
    return found


def effects(*more: Any, justify: str = "") -> Tree:
    """Return the size of words, and what else is said of them."""
    side: list[Any] = [["justify", justify]] if justify else []
    return ["effects", ["font", ["size", "1.27", "1.27"]], *side, *more]


def text_field(name: str, value: str, x: float, y: float, hidden: bool) -> Tree:
    """Return a property of a part."""
    shown: list[Any] = [["hide", "yes"]] if hidden else []
    return ["property", Q(name), Q(value), ["at", f"{x:g}", f"{y:g}", "0"], effects(*shown, justify="left")]


def symbol_on_sheet(part: dict[str, Any], unit: int, place: list[float], root: str, pins: list[str]) -> Tree:
    """Return one unit of a part at a place of the sheet."""
    x, y = place[0], place[1]
    label = part["label"]
    right, down = WORDS.get(label, WORDS.get(label[0], (3.81, -1.27)))
    fields = [
        text_field("Reference", part["reference"], x + right, y + down, False),
        text_field("Value", part["value"], x + right, y + down + 2.54, False),
        text_field("Footprint", part.get("footprint", ""), x, y, True),
        text_field("Datasheet", "", x, y, True),
        text_field("Description", part["what"], x, y, True),
    ]
    numbered: list[Any] = [["pin", Q(pin), ["uuid", identity(label, unit, pin)]] for pin in pins]
    where: Tree = ["path", Q(f"/{root}"), ["reference", Q(part["reference"])], ["unit", str(unit)]]
    answers: list[Any] = [["exclude_from_sim", "no"], ["in_bom", "yes"], ["on_board", "yes"], ["dnp", "no"]]
    return [
        "symbol", ["lib_id", Q(part["symbol"])], ["at", f"{x:g}", f"{y:g}", "0"], ["unit", str(unit)], *answers,
        ["uuid", identity(label, unit)], *fields, *numbered, ["instances", ["project", Q("board"), where]],
    ]  # fmt: skip


def net_label(net: str, x: float, y: float, angle: int, name: str) -> Tree:
    """Return a net's label at a pin's end, away from the part."""
    turned = (angle + 180) % 360
    justify = "right" if turned in (180, 270) else "left"
    return ["global_label", Q(net), ["shape", "passive"], ["at", f"{x:g}", f"{y:g}", str(turned)],
            effects(justify=justify), ["uuid", identity("label", name, x, y)]]  # fmt: skip


def part_on_sheet(part: dict[str, Any], places: list[list[float]], library: Tree, root: str) -> list[Tree]:
    """Return a part's units, with a label or a mark that it is not connected at each pin."""
    pins, nets = pins_of(library), {pin["pin"]: pin["net"] for pin in part["pins"]}
    units = sorted({unit for unit, *_ in pins.values()} - {0}) or [1]
    out: list[Tree] = []
    for unit, place in zip(units, places, strict=True):
        out.append(symbol_on_sheet(part, unit, place, root, [n for n, (u, *_) in pins.items() if u in (0, unit)]))
        marks: dict[tuple[float, float], Tree] = {}
        for number, (at, px, py, angle) in pins.items():
            x, y = round(place[0] + px, 2), round(place[1] - py, 2)
            if at not in (0, unit):
                continue
            free: Tree = ["no_connect", ["at", f"{x:g}", f"{y:g}"], ["uuid", identity(part["label"], "free", number)]]
            marks[x, y] = net_label(nets[number], x, y, angle, number) if number in nets else free
        out += marks.values()
    return out


def flags(root: str) -> list[Tree]:
    """Return the marks that say which nets are supplied from outside."""
    out: list[Tree] = []
    for index, net in enumerate(FLAGGED):
        x, y = 30.48 + 20.32 * index, 187.96
        name = f"#FLG{index + 1}"
        part = {
            "label": name,
            "reference": name,
            "value": "PWR_FLAG",
            "symbol": "power:PWR_FLAG",
            "what": "net supplied",
        }
        drawn = symbol_on_sheet(part, 1, [x, y], root, ["1"])
        out += [drawn, net_label(net, x, y, 90, net)]
    return out


def schematic(parts: list[dict[str, Any]], places: dict[str, Any]) -> Tree:
    """Return the whole sheet."""
    root = identity("sheet")
    names = sorted({part["symbol"] for part in parts} | {"power:PWR_FLAG"})
    library = {name: library_symbol(name) for name in names}
    drawn: list[Any] = []
    for part in parts:
        place = places[part["label"]]["sheet"]
        many = place if isinstance(place[0], list) else [place]
        drawn += part_on_sheet(part, many, library[part["symbol"]], str(root))
    said = ["comment", "1", Q("Written from board.toml. Nobody has soldered it yet")]
    block: Tree = ["title_block", ["title", Q("Board circuit of the wiring guide")], said]
    return [
        "kicad_sch", ["version", "20250114"], ["generator", Q("musclewire")], ["generator_version", Q("9.0")],
        ["uuid", root], ["paper", Q("A4")], block, ["lib_symbols", *library.values()], *drawn, *flags(str(root)),
        ["sheet_instances", ["path", Q("/"), ["page", Q("1")]]], ["embedded_fonts", "no"],
    ]  # fmt: skip
