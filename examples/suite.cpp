// Tests an odometry on the drives of `diffdrive suite`: c++ -std=c++17 -O2 -o suite suite.cpp && ./suite cases/*.csv
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

static const double pi = std::acos(-1.0);
struct Reading { double t, left, right; };

struct Odometry {
    double x, y, theta, left_radius, right_radius, track, range;  // metres for each unit; range of a counter
    Reading last = {-INFINITY, 0, 0};

    void update(Reading now) {
        if (!std::isfinite(now.t + now.left + now.right) || now.t <= last.t) return;  // holds the pose
        if (std::isfinite(last.t)) {
            const double left = left_radius * step(now.left - last.left);
            const double right = right_radius * step(now.right - last.right), half = (right - left) / track / 2;
            const double chord = (left + right) / 2 * (half == 0 ? 1 : std::sin(half) / half);
            x += chord * std::cos(theta + half), y += chord * std::sin(theta + half), theta += 2 * half;
        }
        last = now;
    }
    double step(double by) const { return range > 0 ? by - range * std::floor(by / range + 0.5) : by; }
};

bool passes(const char *path) {
    std::ifstream file(path);
    std::string line, word;
    std::map<std::string, double> h;
    std::getline(file, line);
    for (std::istringstream words(line); words >> word;)
        if (const auto at = word.find('='); at != word.npos) h[word.substr(0, at)] = std::atof(&word[at + 1]);
    const double tick = line.find("unit=ticks") != line.npos ? 2 * pi / h["ticks_per_revolution"] : 1;
    Odometry odometry{h["x"], h["y"], h["theta"], tick * h["left_radius"], tick * h["right_radius"], h["track_width"],
                      h["counter_bits"] > 0 ? std::exp2(h["counter_bits"]) : 0};
    double worst = h.count("tolerance") ? 0 : INFINITY, x, y, theta;
    for (Reading now; std::getline(file, line);) {
        const char *row = line.c_str();
        if (std::sscanf(row, "%lf,%lf,%lf,%lf,%lf,%lf", &now.t, &now.left, &now.right, &x, &y, &theta) != 6) continue;
        odometry.update(now);
        const double turn = std::remainder(odometry.theta - theta, 2 * pi) * odometry.track / 2;
        const double gap = std::hypot(odometry.x - x, odometry.y - y, turn);
        if (!(gap <= worst)) worst = std::isfinite(gap) ? gap : INFINITY;
    }
    const char *verdict = worst <= h["tolerance"] ? "ok  " : "FAIL";
    std::printf("%s %s: off by %.1e m, at most %.1e m\n", verdict, path, worst, h["tolerance"]);
    return worst <= h["tolerance"];
}

int main(int count, char **paths) {
    int failed = 0;
    for (int k = 1; k < count; ++k) failed += !passes(paths[k]);
    return failed > 0;
}
