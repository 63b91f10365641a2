from diffdrive_mj.estimation import closed_forms as closed_forms
from diffdrive_mj.estimation import course as course
from diffdrive_mj.estimation import course_noise as course_noise
from diffdrive_mj.estimation import course_tracker as course_tracker
from diffdrive_mj.estimation import derivatives as derivatives
from diffdrive_mj.estimation import sensitivities as sensitivities
from diffdrive_mj.estimation import straightness as straightness
