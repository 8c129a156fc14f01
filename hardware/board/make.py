"""Write schematic, board and what is made from it, and let KiCad 9 judge: python3 make.py

- board.kicad_sch, board.kicad_pcb: from ../../src/musclewire/extras/board/parts_lists/board.toml and placement.toml
- checks/netlist.xml: what KiCad reads from the schematic
- checks/erc.json, checks/drc.json: KiCad's rule checks, the second with parity of schematic and board
- fabrication/: Gerbers, drill file, bill of materials, schematic to print
- checks/checked.toml: KiCad's version, and SHA-256 of what was judged and of what was made from it
- ../../docs/images/board_layout.png: the picture in the wiring guide
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from layout import layout
from s_expressions import Tree, load, written
from schematic import identity, reference, schematic

HERE = Path(__file__).resolve().parent
PARTS = HERE.parents[1] / "src/musclewire/extras/board/parts_lists/board.toml"
SCHEMATIC, BOARD = HERE / "board.kicad_sch", HERE / "board.kicad_pcb"
CHECKS, MADE = HERE / "checks", HERE / "fabrication"
BILL = MADE / "bom.csv"
PICTURE = HERE.parents[1] / "docs/images/board_layout.png"
JUDGED = ("board.kicad_sch", "board.kicad_pcb", "board.kicad_pro")
DRAWN = {"footprint", "segment", "via", "zone", "gr_line", "gr_text", "pad"} | {
    f"fp_{kind}" for kind in ("line", "rect", "circle", "arc", "poly", "text")
}
COPPER = "F.Cu,B.Cu,F.Mask,B.Mask,F.Silkscreen,Edge.Cuts"


def kicad(*words: object) -> None:
    """Run kicad-cli in this folder. Raises CalledProcessError if it fails."""
    subprocess.run(["kicad-cli", *map(str, words)], cwd=HERE, check=True, stdout=subprocess.DEVNULL)


def settle(path: Path) -> None:
    """Put what pcbnew has written, by identities of chance, into the same order with the same identities each time."""
    tree = in_order(without_identities(load(path)))
    count = iter(range(10**6))
    path.write_text(written(with_identities(tree, count)) + "\n", encoding="utf-8")


def without_identities(tree: Tree) -> Tree:
    """Return a list without the identities in it."""
    kept = [item for item in tree if not (isinstance(item, list) and item[:1] == ["uuid"])]
    return [without_identities(item) if isinstance(item, list) else item for item in kept]


def in_order(tree: Tree) -> Tree:
    """Return a board or a footprint with what is drawn in it sorted by its text, after all else."""
    inner: Tree = [in_order(item) if isinstance(item, list) and item[0] == "footprint" else item for item in tree]
    drawn = [item for item in inner if isinstance(item, list) and str(item[0]) in DRAWN]
    return [*(item for item in inner if not any(item is one for one in drawn)), *sorted(drawn, key=written)]


def with_identities(tree: Tree, count: Iterator[int]) -> Tree:
    """Return a list with numbered identities for what KiCad gives one."""
    inner: Tree = [with_identities(item, count) if isinstance(item, list) else item for item in tree]
    own = str(tree[0]) in DRAWN or tree[0] == "property"
    return [*inner, ["uuid", identity("board", next(count))]] if own else inner


def draw(parts: list[dict[str, Any]], placement: dict[str, Any]) -> None:
    """Write schematic, netlist and board."""
    SCHEMATIC.write_text(written(schematic(parts, placement["place"])) + "\n", encoding="utf-8")
    kicad("sch", "export", "netlist", "--format", "kicadxml", "-o", CHECKS / "netlist.xml", SCHEMATIC.name)
    netlist = (CHECKS / "netlist.xml").read_text("utf-8")
    (CHECKS / "netlist.xml").write_text(netlist.replace(f"{HERE}/", ""), encoding="utf-8")
    project = (HERE / "board.kicad_pro").read_text("utf-8")
    layout(BOARD, parts, placement, CHECKS / "netlist.xml")
    settle(BOARD)
    (HERE / "board.kicad_pro").write_text(project, encoding="utf-8")
    (HERE / "board.kicad_prl").unlink(missing_ok=True)


def judge() -> None:
    """Let KiCad check its rules."""
    every = ("--severity-all", "--format", "json")
    kicad("sch", "erc", *every, "-o", CHECKS / "erc.json", SCHEMATIC.name)
    kicad("pcb", "drc", "--schematic-parity", *every, "-o", CHECKS / "drc.json", BOARD.name)


def make() -> None:
    """Export what a maker of boards needs, and pictures."""
    shutil.rmtree(MADE, ignore_errors=True)
    MADE.mkdir()
    kicad("pcb", "export", "gerbers", "--layers", COPPER, "-o", MADE, BOARD.name)
    kicad("pcb", "export", "drill", "-o", f"{MADE}/", BOARD.name)
    fields = "Reference,Value,Footprint,${QUANTITY}"
    kicad("sch", "export", "bom", "--fields", fields, "--group-by", "Value,Footprint", "-o", BILL, SCHEMATIC.name)
    kicad("sch", "export", "pdf", "-o", MADE / "schematic.pdf", SCHEMATIC.name)
    kicad("pcb", "render", "--side", "top", "-w", "1100", "--height", "880", "-o", PICTURE, BOARD.name)


def note() -> None:
    """Write down which KiCad judged which files, and what was made with them."""
    version = subprocess.run(["kicad-cli", "version"], check=True, capture_output=True, text=True).stdout.strip()
    made = [CHECKS / "netlist.xml", *sorted(MADE.iterdir())]
    lines = [f'kicad = "{version}"']
    for title, files in (("judged", [HERE / name for name in JUDGED]), ("made", made)):
        sums = [(path.relative_to(HERE), hashlib.sha256(path.read_bytes()).hexdigest()) for path in files]
        lines += ["", f"[{title}]", *(f'"{path}" = "{value}"' for path, value in sums)]
    (CHECKS / "checked.toml").write_text("\n".join([*lines, ""]), encoding="utf-8")


def main() -> None:
    """Write, judge, make."""
    CHECKS.mkdir(exist_ok=True)
    listed = tomllib.loads(PARTS.read_text("utf-8"))["part"]
    parts = [{**part, "reference": reference(part["label"])} for part in listed if part.get("symbol")]
    draw(parts, tomllib.loads((HERE / "placement.toml").read_text("utf-8")))
    judge()
    make()
    note()


if __name__ == "__main__":
    main()
