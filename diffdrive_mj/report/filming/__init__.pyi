from diffdrive_mj.report.filming.films import Film as Film
from diffdrive_mj.report.filming.films import film as film
from diffdrive_mj.report.filming.strobes import strobe as strobe
