"""Figures of one look: styles by name, for a screen, slides and the columns of journals."""

from musclewire.figures.style import FigureStyle, figure_style, figure_style_names
from musclewire.figures.styled_figure import StyledFigure, one_panel, panel_rows, panels_side_by_side

__all__ = [
    "FigureStyle",
    "StyledFigure",
    "figure_style",
    "figure_style_names",
    "one_panel",
    "panel_rows",
    "panels_side_by_side",
]
