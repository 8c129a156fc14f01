"""Sizes and fonts of figures by name: a screen, slides, the columns of journals."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from musclewire.errors import CallerError, nearest_hint
from musclewire.pages import STYLE

# A figure at least so wide has its panels side by side; it lies between one column and two of every journal here.
WIDE_MM = 120.0
# Height of a panel, in lines of its letters.
LINES_HIGH = 14.0
POINT_MM = 25.4 / 72.0


class SubstituteFontWarning(UserWarning):
    """A journal's fonts are not installed: the figure has the letters of another one."""


@dataclass(frozen=True)
class FigureStyle:
    """Size and letters of a figure."""

    name: str
    width_mm: float
    max_height_mm: float  # 0 where nothing limits it
    font_pt: float
    small_pt: float  # at ticks and in legends
    line_pt: float  # width of lines of data
    grid: bool
    fonts: tuple[str, ...]  # the first that is installed is taken
    source: str  # where the numbers come from

    @property
    def wide(self) -> bool:
        """Whether two panels fit side by side."""
        return self.width_mm >= WIDE_MM

    @property
    def panel_height_mm(self) -> float:
        """Height of one panel [mm], from the size of its letters."""
        return LINES_HIGH * self.font_pt * POINT_MM

    @property
    def substitute(self) -> str:
        """What stands in for the style's own fonts, in words; "" if one of them is installed."""
        *own, last = self.fonts
        if not own or installed(self.fonts)[0] != last:
            return ""
        return f"none of the fonts {', '.join(own)} is installed: the figure's letters are {last}"

    @property
    def settings(self) -> Mapping[str, Any]:
        """What matplotlib calls these numbers: its rcParams."""
        small = dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), self.small_pt)
        # Axes and ticks at half the width of the data, within the 0.25 to 1 pt that journals print.
        thin = dict.fromkeys(("axes.linewidth", "xtick.major.width", "ytick.major.width"), 0.5 * min(self.line_pt, 2.0))
        return {
            **STYLE,
            **small,
            **thin,
            "font.family": installed(self.fonts),
            "font.size": self.font_pt,
            "axes.titlesize": self.font_pt,
            "axes.labelsize": self.font_pt,
            "axes.grid": self.grid,
            "grid.linewidth": 0.5 * self.line_pt,
            "lines.linewidth": self.line_pt,
            "lines.markersize": 3.0 * self.line_pt,
            "xtick.color": "#222222",
            "ytick.color": "#222222",
            "pdf.fonttype": 42,  # letters stay letters: journals refuse outlines and bitmaps of them
            "savefig.dpi": 300.0,
            "figure.facecolor": "white",
            "savefig.facecolor": "white",
        }


@functools.cache
def _styles() -> Mapping[str, FigureStyle]:
    text = (files("musclewire.figures") / "styles.toml").read_text("utf-8")
    table = tomllib.loads(text)
    return {name: FigureStyle(name=name, **{**row, "fonts": tuple(row["fonts"])}) for name, row in table.items()}


def figure_style_names() -> tuple[str, ...]:
    """Return the names of the styles, "screen" first."""
    return tuple(_styles())


def figure_style(name: str) -> FigureStyle:
    """Return a style by its name: "screen", or a journal's column as "ieee-single" or "elsevier-double"."""
    styles = _styles()
    if name not in styles:
        raise CallerError(f"there is no figure style '{name}'{nearest_hint(name, styles)}")
    return styles[name]


@functools.cache
def installed(fonts: tuple[str, ...]) -> list[str]:
    """Return those of some fonts that are installed; the last comes with matplotlib."""
    from matplotlib.font_manager import fontManager

    known = {font.name for font in fontManager.ttflist}
    return [name for name in fonts if name in known]
