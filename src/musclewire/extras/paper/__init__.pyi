"""The list of names that other rooms may use."""

from ._known_failures import known_failures as known_failures
from ._reproduce.all_checks import all_checks as all_checks
from ._reproduce.measures import lowest_place as lowest_place
from ._reproduce.measures import outside_band as outside_band
from ._reproduce.paper_checks import Origin as Origin
from ._reproduce.paper_checks import PaperCheck as PaperCheck
from ._reproduce.paper_checks import SeedResult as SeedResult
from ._reproduce.paper_checks import bars as bars
from ._reproduce.paper_checks import selected as selected
from ._reproduce.reproduction import DEFAULT_SEEDS as DEFAULT_SEEDS
from ._reproduce.reproduction import SeedCallbacks as SeedCallbacks
from ._reproduce.reproduction import numbers_of_seeds as numbers_of_seeds
from ._reproduce.section2 import FORCE_RATIOS as FORCE_RATIOS
from ._reproduce.verdicts import ReproductionRow as ReproductionRow
from ._reproduce.verdicts import row_of_check as row_of_check
