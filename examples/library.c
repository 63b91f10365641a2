/* Odometry as a shared library.
   cc -O2 -shared -fPIC -o libodometry.so library.c -lm && diffdrive judge --robot ct_bot -- ./libodometry.so */
#include "odometry.h"
#include <math.h>

static struct robot robot;
static double x, y, theta, last[2];
static int started;

void start(const struct robot *given) {
    robot = *given;
    x = given->x, y = given->y, theta = given->theta;
    started = 0;
}

void update(double t, double left, double right, double pose[3]) {
    if (started) {
        double dl = robot.left_radius * (left - last[0]), dr = robot.right_radius * (right - last[1]);
        double half = (dr - dl) / (2 * robot.track_width);
        double chord = (dl + dr) / 2 * (half == 0 ? 1 : sin(half) / half);
        x += chord * cos(theta + half);
        y += chord * sin(theta + half);
        theta += 2 * half;
    }
    (void)t;
    started = 1;
    last[0] = left, last[1] = right;
    pose[0] = x, pose[1] = y, pose[2] = theta;
}
