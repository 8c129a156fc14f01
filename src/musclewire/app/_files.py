"""Files a command is going to write: what can be wrong with them is said before any work is done."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from musclewire.app._output import say
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.sensing import SensingModel

FIGURES = (".svg", ".png", ".pdf")


def require_folder(path: Path) -> None:
    """Raise CallerError if the folder of a file does not exist."""
    if not path.parent.is_dir():
        raise CallerError(f"{path}: there is no folder {path.parent}; make it first")


def require_free(path: Path, overwrite: bool) -> None:
    """Raise CallerError for a file that would replace another, or that has no folder to go to."""
    if path.exists() and not overwrite:
        raise CallerError(f"{path} exists: give another name or --overwrite")
    require_folder(path)


def require_recording_file(path: Path, overwrite: bool) -> None:
    """Raise CallerError for a recording of another kind, or one that would replace a file or an unfinished run."""
    from musclewire.signals import refuse_unfinished

    if path.suffix != ".h5":
        raise CallerError(
            f"{path}: a run is recorded as .h5 (it survives a crash); end its name so, 'musclewire import' converts"
        )
    refuse_unfinished(path, overwrite)
    require_folder(path)


def opened_model(path: Path) -> SensingModel:
    """Read a model file, and say on stderr what was made of an older one."""
    from musclewire.sensing import load_model

    found = load_model(path)
    if found.converted:
        say(found.converted)
    return found


def require_model_file(path: Path) -> None:
    """Raise CallerError if a model would replace something that is not a model."""
    from musclewire.sensing import load_model

    if path.suffix != ".json":
        raise CallerError(f"{path}: a model is a .json file, end its name so")
    if path.exists():
        try:
            load_model(path)
        except CallerError:
            raise CallerError(f"{path} exists and is not a model: give another name") from None
    require_folder(path)


def require_figure_file(path: Path | None) -> None:
    """Raise CallerError for a kind of picture that is not written here."""
    if path is None:
        return
    if path.suffix not in FIGURES:
        raise CallerError(f"{path}: a figure is one of {', '.join(FIGURES)}: end its name so")
    require_folder(path)


def require_zip_file(path: Path | None) -> None:
    """Raise CallerError for an archive whose name does not end in .zip."""
    if path is None:
        return
    if path.suffix != ".zip":
        raise CallerError(f"{path}: the Arduino IDE takes a .zip: give it that ending")
    require_folder(path)


def save_figure(axes: Any, path: Path) -> None:
    """Write a figure, or the figure of some axes, whole or not at all."""
    from musclewire.signals import write_whole

    def write(part: Path) -> None:
        axes.figure.savefig(part, format=path.suffix.removeprefix("."))

    write_whole(path, write)
