// Tests an odometry on the drives of `diffdrive suite`: javac Suite.java && java Suite cases/*.csv
import java.io.IOException;
import java.nio.file.*;
import java.util.*;

public class Suite {
    private final double leftRadius, rightRadius, track, range; // metres for each unit; range of a counter that wraps
    private double x, y, theta;
    private double[] last; // t, left, right

    Suite(Map<String, String> header) {
        double tick = header.get("unit").equals("ticks") ? 2 * Math.PI / number(header, "ticks_per_revolution") : 1;
        leftRadius = tick * number(header, "left_radius");
        rightRadius = tick * number(header, "right_radius");
        track = number(header, "track_width");
        range = header.containsKey("counter_bits") ? Math.pow(2, number(header, "counter_bits")) : 0;
        x = number(header, "x"); y = number(header, "y"); theta = number(header, "theta");
    }

    void update(double... now) {
        boolean late = last != null && now[0] <= last[0];
        if (late || !Arrays.stream(now).allMatch(Double::isFinite)) return; // holds the pose
        if (last != null) {
            double left = leftRadius * step(now[1] - last[1]), right = rightRadius * step(now[2] - last[2]);
            double half = (right - left) / track / 2;
            double chord = (left + right) / 2 * (half == 0 ? 1 : Math.sin(half) / half);
            x += chord * Math.cos(theta + half);
            y += chord * Math.sin(theta + half);
            theta += 2 * half;
        }
        last = now;
    }

    private double step(double ticks) { return range > 0 ? ticks - range * Math.floor(ticks / range + 0.5) : ticks; }

    static double number(Map<String, String> header, String name) { return Double.parseDouble(header.get(name)); }

    static boolean passes(String path) throws IOException {
        List<String> lines = Files.readAllLines(Path.of(path));
        Map<String, String> header = new HashMap<>();
        for (String word : lines.get(0).substring(14).split(" ")) header.put(word.split("=")[0], word.split("=")[1]);
        Suite odometry = new Suite(header);
        double worst = 0, most = number(header, "tolerance");
        for (String line : lines.subList(2, lines.size())) {
            double[] row = Arrays.stream(line.split(",")).mapToDouble(Double::parseDouble).toArray();
            odometry.update(row[0], row[1], row[2]);
            double turn = Math.IEEEremainder(odometry.theta - row[5], 2 * Math.PI) * odometry.track / 2;
            double gap = Math.hypot(odometry.x - row[3], odometry.y - row[4]);
            worst = Math.max(worst, Math.hypot(gap, turn)); // NaN stays
        }
        System.out.printf("%s %s: off by %.1e m, at most %.1e m%n", worst <= most ? "ok  " : "FAIL", path, worst, most);
        return worst <= most;
    }

    public static void main(String[] paths) throws IOException {
        boolean ok = true;
        for (String path : paths) ok &= passes(path);
        System.exit(ok ? 0 : 1);
    }
}
