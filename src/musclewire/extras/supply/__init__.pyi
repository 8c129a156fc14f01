"""The list of names that other rooms may use."""

from ._catalogue_check import PULL_STRESS_PA as PULL_STRESS_PA
from ._text import table_text as table_text
from ._wire_table import wire_table as wire_table
