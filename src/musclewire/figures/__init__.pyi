"""The list of names that other rooms may use."""

from ._style import SubstituteFontWarning as SubstituteFontWarning
from ._style import figure_style as figure_style
from ._style import figure_style_names as figure_style_names
from ._styled_figure import StyledFigure as StyledFigure
from ._styled_figure import axes_to_draw_on as axes_to_draw_on
from ._styled_figure import new_figure as new_figure
from ._styled_figure import one_panel as one_panel
from ._styled_figure import panel_grid as panel_grid
from ._styled_figure import panel_rows as panel_rows
from ._styled_figure import panels_side_by_side as panels_side_by_side
