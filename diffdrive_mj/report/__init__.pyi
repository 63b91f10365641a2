from diffdrive_mj._text import table as table
from diffdrive_mj.report import chance as chance
from diffdrive_mj.report import figures as figures
from diffdrive_mj.report import marks as marks
from diffdrive_mj.report import plots as plots
from diffdrive_mj.report.experiment import Bound as Bound
from diffdrive_mj.report.experiment import Report as Report
from diffdrive_mj.report.program import main as main
