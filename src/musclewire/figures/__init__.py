"""Figures of one look: styles by name, for a screen, slides and the columns of journals."""

from musclewire.figures.style import FigureStyle, SubstituteFontWarning, figure_style, figure_style_names

__all__ = ["FigureStyle", "SubstituteFontWarning", "figure_style", "figure_style_names"]
