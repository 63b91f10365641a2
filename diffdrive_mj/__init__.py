"""diffdrive_mj: how wrong a differential-drive robot's odometry will be, and why, before it drives."""

from diffdrive_mj import _lazy

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
