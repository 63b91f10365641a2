"""Drives and poses from files and back."""

from diffdrive_mj.logs.csv import Columns as Columns
from diffdrive_mj.logs.csv import read_csv as read_csv
from diffdrive_mj.logs.csv import write_csv as write_csv
from diffdrive_mj.logs.formats import read as read
from diffdrive_mj.logs.formats import read_poses as read_poses
from diffdrive_mj.logs.formats import write as write
from diffdrive_mj.logs.optiodom import optiodom_robot as optiodom_robot
from diffdrive_mj.logs.optiodom import read_optiodom as read_optiodom
from diffdrive_mj.logs.topics import Topics as Topics
from diffdrive_mj.logs.wpilog import Entries as Entries
