"""The list of names that other rooms may use."""

from ._finger.comparison import PullingScheme as PullingScheme
from ._finger.comparison import compare_schemes as compare_schemes
from ._finger.finger_file_text import finger_geometry as finger_geometry
from ._finger.shape import finger_shape as finger_shape
from ._serpentine.analysis import PretensionerDesign as PretensionerDesign
from ._serpentine.analysis import PretensionerDuty as PretensionerDuty
from ._serpentine.geometry import AvailableRoom as AvailableRoom
from ._serpentine.outline import serpentine_drawing as serpentine_drawing
from ._serpentine.sizing import PretensionerRequest as PretensionerRequest
from ._serpentine.sizing import design_pretensioner as design_pretensioner
