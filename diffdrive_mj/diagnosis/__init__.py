"""What looks wrong with a drive, and why."""

from diffdrive_mj.diagnosis.drives import suspicions as suspicions
