"""What all pages share: style sheet, key numbers as cards, tables, the look of figures, figures as text in a page."""

from musclewire.pages.page import (
    AVERAGE,
    COOLING,
    HEATING,
    PAPER,
    STYLE,
    TARGET,
    NumberCard,
    cards,
    page,
    svg,
    svg_in_frame,
    table,
    table_rows,
)

__all__ = [
    "AVERAGE",
    "COOLING",
    "HEATING",
    "PAPER",
    "STYLE",
    "TARGET",
    "NumberCard",
    "cards",
    "page",
    "svg",
    "svg_in_frame",
    "table",
    "table_rows",
]
