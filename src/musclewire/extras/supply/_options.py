"""Options of the commands that simulate a drive and size a supply."""

from __future__ import annotations

from math import inf

from musclewire.app import option, own_help, quantity

SUPPLY = quantity("--supply", "V", "Supply voltage, as '5 V'.")
CURRENT = quantity("--current", "A", "Current that is held, as '200 mA'; --supply is then its limit.")
OFF_AFTER = quantity("--off-after", "s", "Time until switching off, as '1 s'.", 0.01, inf)
DUTY = quantity("--duty", "", "Heat in pulses until --off-after: on for this part of each period, as '40 %'.", 0.0, 1.0)
DUTY_PERIOD = quantity("--duty-period", "s", "Period of the pulses of --duty, as '1 s'.", 0.01, inf)
DURATION = quantity("--duration", "s", "Duration of the whole run; by default long enough to cool.", 0.0, 86400.0)
LOAD = own_help("--load", "Weight that the wire pulls, as '1.4 N'.")
AIR = own_help("--ambient", "Temperature of the air around the wire, as '22 degC'.")
STRESS = quantity("--stress", "Pa", "The load as a stress; without --load and --stress it is '172 MPa'.")
SPRING = quantity("--spring", "N/m", "A spring to pull, as '588.6 N/m'.")
TABLE = option("--table", help="Show current, voltage and shunt of all wires at --wire-length, and exit.")
