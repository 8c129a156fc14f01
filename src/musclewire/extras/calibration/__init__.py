"""The physical numbers of a user's own wire, and a model from resistance alone; the estimator on such a wire."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
