"""What is wrong with a recording and with a closed loop: each finding with its numbers and what to do.

And what a loop makes of it while it runs: resistance that is scaled by the height of B or by a known strain.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
