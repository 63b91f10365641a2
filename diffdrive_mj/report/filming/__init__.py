"""Films and pictures of the robot, and of where it believes it is; the only part of `report` that needs MuJoCo."""

from diffdrive_mj import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
