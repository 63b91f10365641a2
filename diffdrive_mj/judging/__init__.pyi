from diffdrive_mj.judging import beliefs as beliefs
from diffdrive_mj.judging import bumps as bumps
from diffdrive_mj.judging import full_speed as full_speed
from diffdrive_mj.judging import random_drives as random_drives
from diffdrive_mj.judging import real_robot as real_robot
from diffdrive_mj.judging import rolling as rolling
from diffdrive_mj.judging import sampled as sampled
from diffdrive_mj.judging import standards as standards
