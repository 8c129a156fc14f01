"""The command that brings a model up to the wire of today, and the same move before or after a closed loop."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app._figure_options import FigureOptions
from musclewire.app._files import opened_model, require_model_file, require_recording_file
from musclewire.app._options import (
    AMBIENT,
    CYCLES_MADE,
    HOME,
    HOMED_MODEL,
    LOAD,
    OVERWRITE,
    SEED,
    SWEEP_FILE,
    RigName,
    in_si,
    own_help,
)
from musclewire.app._output import Result, progress_bar, warn
from musclewire.app._rig_options import TimingOptions
from musclewire.app._stopping import stops_between_samples
from musclewire.errors import CallerError, nearest_hint

if TYPE_CHECKING:
    from musclewire.app._answers import HomeFound
    from musclewire.identify import Homing
    from musclewire.rigs import GuardedRig
    from musclewire.sensing import SensingModel

WHEN = ("start", "idle", "never")


@dataclass(frozen=True)
class HomeOptions:
    """When a closed loop makes a home move, what is known of load and air, and where its model is written.

    Never, unless asked: a home move heats the wire for half a minute, and is refused under another load than that of
    the characterization.
    """

    home: Annotated[str, HOME] = "never"
    load: Annotated[str | None, LOAD] = None
    ambient: Annotated[str | None, AMBIENT] = None
    homed_model: Annotated[Path | None, HOMED_MODEL] = None

    def check(self, *, on_board: bool) -> None:
        """Raise CallerError for an unknown time, and for options that would have no effect."""
        if self.home not in WHEN:
            raise CallerError(f"--home: there is no '{self.home}'{nearest_hint(self.home, WHEN)}")
        given = {"--load": self.load, "--ambient": self.ambient, "--homed-model": self.homed_model}
        without_move = [name for name, value in given.items() if value is not None] if self.home == "never" else []
        if without_move:
            raise CallerError(
                f"{without_move[0]} belongs to a home move: give --home start or --home idle, or leave it out"
            )
        if self.home == "idle" and self.homed_model is None:
            raise CallerError("--home idle finds a model for the next run: name its file by --homed-model")
        if on_board and self.home != "never":
            raise CallerError("--on-board runs by the firmware's own numbers: leave out --home")
        if self.homed_model is not None:
            require_model_file(self.homed_model)

    def given(self) -> dict[str, bool]:
        """Return which of these options were given, by name."""
        return {"--home": self.home != "never"}

    def homed(self, rig: GuardedRig, model: SensingModel) -> Homing:
        """Make the home move, and write its model if a file is named."""
        from musclewire.experiment import home as run_home
        from musclewire.experiment import home_duration_s

        load_n, ambient_k = in_si("--load", self.load), in_si("--ambient", self.ambient)
        with progress_bar("Home move", home_duration_s(rig, model), rig) as on_sample:
            found = run_home(rig, model, load_n=load_n, ambient_k=ambient_k, on_sample=on_sample)
        if self.homed_model is not None:
            found.model.save(self.homed_model)
        return found


def home(
    rig: RigName,
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file from 'musclewire fit'.")],
    output: Annotated[Path, own_help("--output", "New model file to write (.json).")],
    timing: TimingOptions,
    figure: FigureOptions,
    load: Annotated[str | None, LOAD] = None,
    ambient: Annotated[str | None, AMBIENT] = None,
    cycles_made: Annotated[int | None, CYCLES_MADE] = None,
    sweep: Annotated[Path | None, SWEEP_FILE] = None,
    seed: Annotated[int | None, SEED] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Sweep the wire once and write a model that holds for the wire of today; a changed load is refused."""
    from musclewire.app._answers import HomeAnswer
    from musclewire.experiment import home as run_home
    from musclewire.experiment import home_duration_s
    from musclewire.identify import homing_figure

    figure.check()
    loaded = opened_model(model)
    require_model_file(output)
    if output.exists() and not overwrite:
        raise CallerError(f"{output} exists: give another name or --overwrite")
    if sweep is not None:
        require_recording_file(sweep, overwrite)
    load_n, ambient_k = in_si("--load", load), in_si("--ambient", ambient)
    with stops_between_samples(), timing.open_rig(rig, seed) as opened:
        refused = timing.apply(opened)
        with progress_bar("Home move", home_duration_s(opened, loaded), opened) as on_sample:
            found = run_home(
                opened,
                loaded,
                load_n=load_n,
                ambient_k=ambient_k,
                cycles=None if cycles_made is None else float(cycles_made),
                path=sweep,
                overwrite=overwrite,
                on_sample=on_sample,
            )
    found.model.save(output)
    figure.draw(partial(homing_figure, loaded, found))
    warn(refused)
    answer = HomeAnswer(**vars(home_found(found)), model=str(output), warnings=tuple(refused))
    return Result(answer, f"{home_text(found)}\nmodel written to {output}")


def home_found(found: Homing) -> HomeFound:
    """Return what a home move found as an answer has it."""
    from musclewire.app._answers import HomeFound

    numbers = ("resistance_max_moved_ohm", "resistance_max_moved_std_ohm", "resistance_min_moved_ohm",
               "resistance_min_moved_std_ohm", "warming_moved_k", "misfit_ohm", "notes")  # fmt: skip
    return HomeFound(
        **vars(found.home),
        **{name: getattr(found, name) for name in numbers},
        saw_b_cooling=found.seen.cooling_b_ohm is not None,
        saw_c=found.seen.c_ohm is not None,
    )


def home_text(found: Homing) -> str:
    """Return a home move in a few lines: the load it assumes first, then what it found, then what it did not see."""
    home = found.home
    load = "the load of the characterization" if home.load_n is None else f"a load of {home.load_n:g} N"
    air = "air not measured" if home.ambient_k is None else f"air of {home.ambient_k - 273.15:.1f} degC"
    return "\n".join(
        [
            f"assumed: {load}; {air}",
            f"at B {found.resistance_max_moved_ohm:+.4f} +- {found.resistance_max_moved_std_ohm:.4f} ohm, "
            f"at C {found.resistance_min_moved_ohm:+.4f} +- {found.resistance_min_moved_std_ohm:.4f} ohm",
            f"scale {home.resistance_scale:.4f} +- {home.resistance_scale_std:.4f}, "
            f"offset {home.resistance_offset_ohm:+.3f} +- {home.resistance_offset_std_ohm:.3f} ohm, "
            f"transformation {home.transformation_shift_k:+.1f} +- {home.transformation_shift_std_k:.1f} K",
            "the model is corrected" if home.corrected else "the model keeps its curve",
            *found.notes,
        ]
    )
