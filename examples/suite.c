/* Tests an odometry on the drives of `diffdrive suite`: cc -O2 -o suite suite.c -lm && ./suite FILES */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct robot { double left_radius, right_radius, track, range; }; /* range of a counter that wraps, or 0 */
struct odometry { double x, y, theta, t, left, right; int begun; };

static double step(double by, double range) { return range > 0 ? by - range * floor(by / range + 0.5) : by; }

static void update(struct odometry *o, const struct robot *r, double t, double left, double right) {
    if (!isfinite(t) || !isfinite(left) || !isfinite(right) || (o->begun && t <= o->t)) return; /* holds the pose */
    if (o->begun) {
        double dl = r->left_radius * step(left - o->left, r->range);
        double dr = r->right_radius * step(right - o->right, r->range);
        double half = (dr - dl) / r->track / 2, chord = (dl + dr) / 2 * (half == 0 ? 1 : sin(half) / half);
        o->x += chord * cos(o->theta + half);
        o->y += chord * sin(o->theta + half);
        o->theta += 2 * half;
    }
    o->t = t, o->left = left, o->right = right, o->begun = 1;
}

static double number(const char *header, const char *name) {
    const char *at = strstr(header, name);
    return at ? atof(at + strlen(name)) : 0;
}

static int fails(const char *path) {
    char line[1024] = "";
    FILE *file = fopen(path, "r");
    if (!file || !fgets(line, sizeof line, file)) return printf("FAIL %s: cannot be read\n", path), 1;
    double tick = strstr(line, "unit=ticks") ? 2 * acos(-1) / number(line, " ticks_per_revolution=") : 1;
    double bits = number(line, " counter_bits="), tolerance = number(line, " tolerance="), worst = 0;
    struct robot r = {tick * number(line, " left_radius="), tick * number(line, " right_radius="),
                      number(line, " track_width="), bits > 0 ? exp2(bits) : 0};
    struct odometry o = {number(line, " x="), number(line, " y="), number(line, " theta="), 0, 0, 0, 0};
    double t, left, right, x, y, theta;
    while (fgets(line, sizeof line, file)) {
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf", &t, &left, &right, &x, &y, &theta) != 6) continue;
        update(&o, &r, t, left, right);
        double gap = hypot(hypot(o.x - x, o.y - y), remainder(o.theta - theta, 2 * acos(-1)) * r.track / 2);
        if (!(gap <= worst)) worst = isfinite(gap) ? gap : INFINITY;
    }
    fclose(file);
    printf("%s %s: off by %.1e m, at most %.1e m\n", worst <= tolerance ? "ok  " : "FAIL", path, worst, tolerance);
    return !(worst <= tolerance);
}

int main(int count, char **paths) {
    int failed = 0;
    for (int k = 1; k < count; k++) failed += fails(paths[k]);
    return failed > 0;
}
