"""The robot's parameters from its drives; each method is named by what one drives."""

from diffdrive_mj import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
