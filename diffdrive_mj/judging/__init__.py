"""What to judge by: standard maneuvers with the floor of the physics, random drives, the law of wrong beliefs."""

from diffdrive_mj import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
