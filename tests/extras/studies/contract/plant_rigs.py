"""Plants from outside in the contract suite: modules next to their rig files, two other families of wire."""

from __future__ import annotations

from tests.contract.rig_subject import RigSubject, without_a_test
from tests.places import EXAMPLES

from musclewire.rigs import open_rig

LIANG_ROGERS, DUHEM = EXAMPLES / "plants" / "liang_rogers.toml", EXAMPLES / "plants" / "duhem.toml"

# The maker's 126 ohm/m over 14 cm, and up to 15 % more.
SUBJECTS = (
    RigSubject("another family", without_a_test(lambda: open_rig(LIANG_ROGERS)), (17.6, 20.3)),
    RigSubject("a third family", without_a_test(lambda: open_rig(DUHEM)), (17.6, 20.3)),
)
