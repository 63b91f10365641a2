/* What a shared library has for `diffdrive judge --robot ct_bot -- ./libodometry.so`: two functions. */
#ifndef DIFFDRIVE_ODOMETRY_H
#define DIFFDRIVE_ODOMETRY_H

#ifdef __cplusplus
extern "C" {
#endif

struct robot {
    double left_radius, right_radius, track_width; /* [m] */
    double ticks_per_revolution;                   /* gears included */
    double x, y, theta;                            /* the pose at the first reading [m, m, rad] */
};

/* Called once, before the first reading. */
void start(const struct robot *robot);

/* Called for each reading: its time [s], the wheels' angles since the start [rad]; pose gets x, y [m] and theta [rad]. */
void update(double t, double left, double right, double pose[3]);

#ifdef __cplusplus
}
#endif

#endif
