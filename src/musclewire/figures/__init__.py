"""Figures of one look: styles by name, for a screen, slides and the columns of journals."""

from musclewire.figures.style import FigureStyle, figure_style, figure_style_names

__all__ = ["FigureStyle", "figure_style", "figure_style_names"]
