"""The list of names that other rooms may use."""

from ._page import AVERAGE as AVERAGE
from ._page import COOLING as COOLING
from ._page import HEATING as HEATING
from ._page import PAPER as PAPER
from ._page import STYLE as STYLE
from ._page import TARGET as TARGET
from ._page import NumberCard as NumberCard
from ._page import notebook_table as notebook_table
from ._page import page as page
from ._page import svg as svg
from ._page import svg_in_frame as svg_in_frame
