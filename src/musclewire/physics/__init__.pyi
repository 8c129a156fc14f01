"""The list of names that other rooms may use."""

from ._friction import friction_force_n as friction_force_n
from ._heat import air_thermal_conductivity_w_per_m_k as air_thermal_conductivity_w_per_m_k
from ._heat import convection_coefficient_w_per_m2_k as convection_coefficient_w_per_m2_k
from ._heat import convection_range_note as convection_range_note
from ._heat import nusselt_morgan as nusselt_morgan
from ._heat import rayleigh_of_wire as rayleigh_of_wire
from ._resistance import ELASTIC_POISSON_RATIO as ELASTIC_POISSON_RATIO
from ._resistance import MINIMUM_CURRENT_A as MINIMUM_CURRENT_A
from ._resistance import REFERENCE_TEMPERATURE_K as REFERENCE_TEMPERATURE_K
from ._resistance import ArrayReading as ArrayReading
from ._resistance import series_resistance_ohm as series_resistance_ohm
from ._resistance import wire_resistance as wire_resistance
from ._resistance import wire_resistance_from_current as wire_resistance_from_current
