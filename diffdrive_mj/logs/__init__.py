"""Drives from files and back."""

from diffdrive_mj.logs.csv import Columns as Columns
from diffdrive_mj.logs.csv import read_csv as read_csv
from diffdrive_mj.logs.csv import write_csv as write_csv
from diffdrive_mj.logs.optiodom import optiodom_robot as optiodom_robot
from diffdrive_mj.logs.optiodom import read_optiodom as read_optiodom
