"""What both design commands share: an options file, which has options by their names, and the files they write.

stiffness = "1084.4 N/m"
endpoint = "6 mm"
wire = "paper-100um"
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from musclewire.app import PLOT, own_help, require_figure_file, require_folder
from musclewire.errors import CallerError, nearest_hint
from musclewire_design._options import DRAWING, SOLID
from musclewire_design._solid import require_open_cascade

DRAWINGS, SOLIDS = (".svg", ".dxf"), (".stl", ".step")
# Where results go is said on the command line: the same options may be computed twice.
NOT_IN_A_FILE = {"options_file", "output", "drawing", "solid", "plot", "list_materials", "json"}


def read_options(context: typer.Context, path: Path | None) -> Path | None:
    """Take the values of a options file as defaults of the options; what the command line gives takes precedence.

    Raises CallerError naming file and key.
    """
    if path is None:
        return None
    from musclewire.small_files import read_toml

    table = read_toml(path, "options file")
    known = {str(param.name): param for param in context.command.params if param.name not in NOT_IN_A_FILE}
    for key, value in table.items():
        if key not in known:
            raise CallerError(f"options file {path}: unknown key '{key}'{nearest_hint(key, known)}")
        if isinstance(value, (dict, list)):
            raise CallerError(f"options file {path}: '{key}' must be one value, not {value}")
    context.default_map = {key: found_next_to(value, path) for key, value in table.items()}
    return path


def found_next_to(value: Any, path: Path) -> Any:
    """Return a value; the name of a file that lies next to the options file becomes its path."""
    neighbour = path.parent / value if isinstance(value, str) and value.endswith(".toml") else None
    return str(neighbour) if neighbour is not None and neighbour.exists() else value


def given_options(context: typer.Context) -> list[str]:
    """Return the names of the options that the command line or a options file gave."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    return [
        name for name, source in sources.items() if source is not None and source.name in {"COMMANDLINE", "DEFAULT_MAP"}
    ]


OPTIONS_FILE = typer.Argument(
    metavar="[OPTIONS.toml]",
    help="TOML file with options by their names, as stiffness = '1084.4 N/m'; the command line takes precedence.",
    is_eager=True,
    callback=read_options,
)


@dataclass(frozen=True)
class PartFiles:
    """The files a design command writes."""

    output: Annotated[Path | None, own_help("--output", "Part's file to write (.toml).")] = None
    drawing: Annotated[list[Path] | None, DRAWING] = None
    solid: Annotated[list[Path] | None, SOLID] = None
    plot: Annotated[Path | None, PLOT] = None

    @property
    def drawings(self) -> list[Path]:
        """The drawings, none of them if none was requested."""
        return self.drawing or []

    @property
    def solids(self) -> list[Path]:
        """The solids, none of them if none was requested."""
        return self.solid or []

    def require(self, part: str) -> None:
        """Raise CallerError for files that are not written here, or not without Open CASCADE, before any work."""
        if self.solids:
            require_open_cascade()
        if self.output is not None:
            if self.output.suffix != ".toml":
                raise CallerError(f"{self.output}: a {part} is a .toml file, end its name so")
            require_folder(self.output)
        for drawing in self.drawings:
            if drawing.suffix not in DRAWINGS:
                raise CallerError(f"{drawing}: a drawing is one of {', '.join(DRAWINGS)}: end its name so")
            require_folder(drawing)
        for solid in self.solids:
            if solid.suffix not in SOLIDS:
                raise CallerError(f"{solid}: a solid is one of {', '.join(SOLIDS)}: end its name so")
            require_folder(solid)
        require_figure_file(self.plot)
