"""The list of names that other rooms may use."""

from ._cause import CAUSE_TEXT as CAUSE_TEXT
from ._cause import Cause as Cause
from ._first_heating import height_of_b as height_of_b
from ._first_heating import not_compared as not_compared
from ._health import GRAVE as GRAVE
from ._health import does_not_hold as does_not_hold
from ._health import findings as findings
from ._health import health_metadata as health_metadata
from ._health import health_warnings as health_warnings
from ._known_strain import ScaleByKnownStrain as ScaleByKnownStrain
from ._known_strain import known_strain_in as known_strain_in
from ._known_strain import known_strain_unused as known_strain_unused
from ._missed_target import MissWatch as MissWatch
from ._odd_resistance import odd_resistance as odd_resistance
from ._scale_by_b import KEPT as KEPT
from ._scale_by_b import TODAY as TODAY
from ._scale_by_b import ZEROS as ZEROS
from ._scale_by_b import ScaleByB as ScaleByB
from ._sensed import SETTLE_S as SETTLE_S
from ._sensed import after_approach as after_approach
from ._sensed import valid_share as valid_share
