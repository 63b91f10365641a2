/* Odometry over a pipe: reads t,left,right, in radians or ticks, and answers x,y,theta [m, m, rad].
   cc -O2 -o odometry odometry.c -lm && diffdrive judge --robot ct_bot -- ./odometry */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double number(const char *header, const char *name) {
    const char *at = strstr(header, name);
    return at ? atof(at + strlen(name)) : 0.0;
}

int main(void) {
    char line[1024];
    double rl = 0, rr = 0, b = 1, x = 0, y = 0, theta = 0, last[2] = {0, 0}, t, left, right, scale = 1;
    int first = 1;
    while (fgets(line, sizeof line, stdin)) {
        if (line[0] == '#') {
            rl = number(line, " left_radius=");
            rr = number(line, " right_radius=");
            b = number(line, " track_width=");
            x = number(line, " x=");
            y = number(line, " y=");
            theta = number(line, " theta=");
            if (strstr(line, "unit=ticks")) scale = 2 * acos(-1) / number(line, " ticks_per_revolution=");
        } else if (sscanf(line, "%lf,%lf,%lf", &t, &left, &right) == 3) {
            double dl = first ? 0 : rl * scale * (left - last[0]), dr = first ? 0 : rr * scale * (right - last[1]);
            double half = (dr - dl) / (2 * b), chord = (dl + dr) / 2 * (half == 0 ? 1 : sin(half) / half);
            x += chord * cos(theta + half);
            y += chord * sin(theta + half);
            theta += 2 * half;
            last[0] = left;
            last[1] = right;
            first = 0;
            printf("%.17g,%.17g,%.17g\n", x, y, theta);
        }
    }
    return 0;
}
